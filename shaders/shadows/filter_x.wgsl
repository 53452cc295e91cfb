// Filters rows: one workgroup makes 512 neighbouring texels of one row of one plane. Reads and
// writes of memory run along x; the strips, which do not, go through workgroup memory.
#import common/window.wgsl

const STRIP = 8u;
const LANES = 64u;
const RUN = 512u; // STRIP * LANES

// Words for RUN + taps - 1 texels, one spare word after every STRIP: lanes read at a stride of
// STRIP + 1, which spreads them over the banks.
override TILE_WORDS: u32 = 648u;
// Whether the window fits the tile; longer ones read memory directly.
override TILED: bool = true;

var<workgroup> tile: array<u32, TILE_WORDS>;
var<workgroup> results: array<u32, 576>;

var<private> row: u32;
var<private> first: i32;
var<private> lane: u32;

fn slot(e: u32) -> u32 {
    return e + e / STRIP;
}

fn texel(e: u32) -> u32 {
    return source_words[row + u32(clamp(first + i32(e), 0, i32(params.width) - 1))];
}

fn fetch(j: u32) -> vec2<f32> {
    let e = lane * STRIP + j;
    if TILED {
        return decode(tile[slot(e)]);
    }
    return decode(texel(e));
}

fn emit(i: u32, v: vec2<f32>) {
    results[slot(lane * STRIP + i)] = encode(v);
}

@compute @workgroup_size(64)
fn filter_x(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    lane = local;
    row = (group.z * params.height + group.y) * params.width;
    let x0 = group.x * RUN;
    first = i32(x0) - i32(params.taps / 2u);
    let wanted = min(RUN, params.width - x0);
    // Whole strips: the last lane at work reads taps - 1 texels beyond its strip.
    let strips = (wanted + STRIP - 1u) / STRIP;
    if TILED {
        for (var e = lane; e < strips * STRIP + params.taps - 1u; e += LANES) {
            tile[slot(e)] = texel(e);
        }
    }
    workgroupBarrier();
    if lane < strips {
        filter_strip(ops[group.z]);
    }
    workgroupBarrier();
    for (var e = lane; e < wanted; e += LANES) {
        target_words[row + x0 + e] = results[slot(e)];
    }
}
