//! Why the relative rule was rejected: bright disks where a representative has its own bound.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use dapple_many_lights::{
    Absolute, BoundForm, Form, LightTree, Per, Relative, Shaded, Technique, World, make,
    worlds::{self, Facade},
};
use std::sync::Arc;

fn shaded(technique: &Technique, world: &Arc<World>, tree: &Arc<LightTree>) -> Shaded {
    let mut lighting = make(Form::Reference, technique, world, tree, None).unwrap();
    let mut shaded = Shaded::default();
    lighting.shade(0, true).unwrap();
    lighting.read(&mut shaded).unwrap();
    shaded
}

/// The greatest error of any channel of any pixel.
fn most_off(shaded: &Shaded, truth: &Shaded) -> f32 {
    let off = shaded.radiance.iter().zip(&truth.radiance);
    off.map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max)
}

#[test]
fn the_relative_rule_leaves_disks_and_the_absolute_one_does_not() {
    let (made, keys) = worlds::facade(&Facade { size: [48, 24], ..Facade::default() });
    let tree = Arc::new(LightTree::by_keys(&made.world.lights, &keys).unwrap());
    let world = Arc::new(made.world);
    let absolute = |threshold| {
        let settings = Absolute { threshold, bound: BoundForm::Walter, per: Per::Pixel };
        shaded(&Technique::Absolute(settings), &world, &tree)
    };
    let truth = absolute(0.0);
    let relative = Relative { epsilon: 0.02, bound: BoundForm::Walter };
    let relative = shaded(&Technique::Relative(relative), &world, &tree);
    // The first threshold from above with which the absolute rule's error is a fifth.
    let thresholds = (0..60).map(|step| 0.8_f64.powi(step));
    let kept =
        thresholds.map(absolute).find(|s| 5.0 * most_off(s, &truth) < most_off(&relative, &truth));
    let kept = kept.unwrap();
    assert!(most_off(&relative, &truth) > 2.0 / 255.0);
    // It takes no more nodes for that.
    assert!(kept.work.cut <= relative.work.cut, "{} of {}", kept.work.cut, relative.work.cut);
}
