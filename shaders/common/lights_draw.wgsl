// Ways down a light tree by chance, one number a sibling after the first: as
// crates/many-lights/src/sample/descend.rs, where reasons stand. Importers define how much nodes are
// worth, `worth(node, point) -> vec2<f32>`, and of how many measures that is: MEASURES, 1 or 2.
#import common/lights_tree.wgsl
#import common/lights_shadow.wgsl
#import common/lights_sum.wgsl
#import common/lights_random.wgsl

// Mirrors DrawParams.
struct DrawParams {
    seed: u32,
    // Lights a pixel, or nodes of a cut.
    number: u32,
    // Between slots of a cut, or cuts.
    stride: u32,
    pad: u32,
}

@group(1) @binding(3) var<uniform> params: DrawParams;

// Siblings while one is chosen among them.
struct Choice {
    // Whether any is worth anything, which, and how much.
    any: bool,
    node: u32,
    worth: vec2<f32>,
    sums: vec2<f32>,
    second: bool,
}

// A light that was drawn; the chance is 0 where none was.
struct Drawn {
    leaf: u32,
    chance: f32,
}

// Nodes that the pixel looked at.
var<private> visits: u32;

fn no_choice() -> Choice {
    var second = false;
    if MEASURES == 2u {
        second = random_unit() >= 0.5;
    }
    return Choice(false, 0u, vec2<f32>(0.0), vec2<f32>(0.0), second);
}

fn with_sibling(before: Choice, node: u32, first: bool, point: Point) -> Choice {
    var choice = before;
    let here = worth(node, point);
    var number = 0.0;
    if !first {
        number = random_unit();
    }
    choice.sums += here;
    visits += 1u;
    let one = select(here.x, here.y, choice.second);
    let sum = select(choice.sums.x, choice.sums.y, choice.second);
    if one > 0.0 && (!choice.any || number * sum < one) {
        choice.any = true;
        choice.node = node;
        choice.worth = here;
    }
    return choice;
}

// The mean over the measures of the chosen one's share.
fn chance_of(choice: Choice) -> f32 {
    var chance = 0.0;
    if choice.worth.x > 0.0 {
        chance = choice.worth.x / choice.sums.x;
    }
    if MEASURES == 2u {
        if choice.worth.y > 0.0 {
            chance += choice.worth.y / choice.sums.y;
        }
        chance *= 0.5;
    }
    return chance;
}

fn choose_child(parent: u32, point: Point) -> Choice {
    var choice = no_choice();
    let first = parent + 1u;
    let end = parent + nodes[parent].size;
    for (var child = first; child < end; child += nodes[child].size) {
        choice = with_sibling(choice, child, child == first, point);
    }
    return choice;
}

fn choose_root(point: Point) -> Choice {
    var choice = no_choice();
    let range = ranges[0];
    for (var s = range.x; s < range.y; s++) {
        choice = with_sibling(choice, starts[s], s == range.x, point);
    }
    return choice;
}

// A light below a choice.
fn draw_below(start: Choice, point: Point) -> Drawn {
    var choice = start;
    var chance = 1.0;
    loop {
        if !choice.any {
            return Drawn(0u, 0.0);
        }
        chance *= chance_of(choice);
        if nodes[choice.node].size == 1u {
            return Drawn(choice.node, chance);
        }
        choice = choose_child(choice.node, point);
    }
    return Drawn(0u, 0.0);
}
