//! Random worlds of boxes and lights around one cell, and the cells of cities.

use crate::{
    SuiteError,
    case::{Case, DATA_VARIABLE},
    knob::{self, Knobs},
    problem::{Form, Setting, Technique},
    problems::region_light_visibility::{RegionCase, SPEC},
    verify::{anywhere, rng},
};
use dapple_many_lights::{
    self as lights, Emission, Light, LightTree, LightsError,
    bound::Region,
    region::{
        Direction, Face, Occluders, Precuts, RegionTechnique, Solid, Turn, ViewCell, make,
        truth::{Obstacles, Sight},
    },
    worlds::{CLAMP_M, WINDOW},
};
use dapple_scene::city::OrientedBox;
use glam::{DVec2, DVec3};
use rand::RngExt;
use rand_pcg::Pcg64;
use serde_json::json;
use std::{f64::consts::PI, sync::Arc};

/// Lights, what hides them, and who may see them.
pub struct World {
    /// The lights.
    pub world: Arc<lights::World>,
    /// Over them.
    pub tree: Arc<LightTree>,
    /// Boxes.
    pub occluders: Arc<Occluders>,
    /// May be lit from all four sides.
    pub cell: ViewCell,
}

/// A box and its lights as they were drawn, before they are turned and scaled: coordinates that are
/// halves, so that walls touch, and that are exact in every turn by quarters.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// Lower and upper corners of occluders.
    pub boxes: Vec<[DVec3; 2]>,
    /// Of every kind.
    pub lights: Vec<Light>,
    /// Corners of the cell.
    pub cell: [DVec3; 2],
}

/// What gates ask of a world.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// Lights shine to all sides: none is too weak.
    pub omni: bool,
    /// Occluders may hang in the air.
    pub floating: bool,
}

/// A street's corner: boxes on a grid of half metres, many of which touch, or the cell, or hold it.
pub fn drawn(rng: &mut Pcg64, wanted: Wanted) -> Drawn {
    let half = |rng: &mut Pcg64, from: i32, to: i32| 0.5 * f64::from(rng.random_range(from..to));
    let floating = wanted.floating && rng.random_bool(0.25);
    let mut boxes = Vec::new();
    for _ in 0..rng.random_range(2..36) {
        let foot = if floating { half(rng, 0, 6) } else { -1.0 };
        let min = DVec3::new(half(rng, -40, 40), foot, half(rng, -40, 40));
        let size = DVec3::new(half(rng, 0, 16), half(rng, 1, 13), half(rng, 0, 8));
        boxes.push([min, min + size]);
    }
    // A row of houses whose walls touch.
    let mut at = half(rng, -40, 0);
    let w = half(rng, 6, 30);
    for _ in 0..rng.random_range(2..9) {
        let (width, depth) = (half(rng, 2, 16), half(rng, 1, 6));
        let max = DVec3::new(at + width, half(rng, 1, 13), w + depth);
        boxes.push([DVec3::new(at, -1.0, w), max]);
        at += width;
    }
    let mut lights = Vec::new();
    for index in 0..rng.random_range(10..80) {
        let mut side = || rng.random_range(-25.0..25.0);
        let (x, z) = (side(), side());
        let mut position = DVec3::new(x, rng.random_range(0.0..7.0), z);
        if index % 3 == 0 {
            position = (2.0 * position).round() * 0.5;
        }
        let axis = Direction::ALL[rng.random_range(0..4)].vector();
        lights.push(match wanted.omni || index % 2 == 0 {
            true => Light { position, axis, intensity: DVec3::ONE, emission: Emission::Omni },
            false => Light { position, axis, intensity: DVec3::splat(20.0), emission: WINDOW },
        });
    }
    let min = DVec3::new(half(rng, -12, 12), half(rng, 0, 6), half(rng, -12, 12));
    let size = DVec3::new(half(rng, 0, 9), half(rng, 0, 8), half(rng, 0, 9));
    Drawn { boxes, lights, cell: [min, min + size] }
}

impl Drawn {
    /// As it is, turned by so many degrees, and so large.
    ///
    /// # Errors
    /// None of lights that are drawn.
    pub fn world(&self, turn: Turn, scale: f64) -> Result<World, LightsError> {
        let oriented = |[min, max]: &[DVec3; 2]| {
            let (min, max) = (*min * scale, *max * scale);
            let centre = turn.from(0.5 * (min + max));
            OrientedBox { centre, axis: turn.axis(), half: 0.5 * (max - min) }
        };
        let lights: Vec<Light> = self
            .lights
            .iter()
            .map(|light| Light {
                position: turn.from(light.position * scale),
                axis: turn.from(light.axis),
                intensity: light.intensity * scale * scale,
                ..*light
            })
            .collect();
        let [min, max] = self.cell.map(|corner| corner * scale);
        Ok(World {
            tree: Arc::new(LightTree::median(&lights)?),
            occluders: Arc::new(Occluders::of_boxes(self.boxes.iter().map(oriented).collect())),
            cell: cell(turn, min, max),
            world: Arc::new(lights::World {
                origin: DVec3::ZERO,
                lights,
                frames: Vec::new(),
                clamp_m: CLAMP_M,
                occluders: None,
            }),
        })
    }
}

/// A cell that may be lit from all four sides, between turned corners.
pub fn cell(turn: Turn, min: DVec3, max: DVec3) -> ViewCell {
    let (local_min, local_max) = turn.local_around(min, max);
    let region = Region {
        min: local_min,
        max: local_max,
        normal_axis: DVec3::Y,
        normal_spread_rad: PI,
        albedo: DVec3::splat(0.5),
    };
    ViewCell { turn, faces: [Some(Face { min, max, region }); 4] }
}

/// An upright box between two corners.
pub fn upright([min, max]: [DVec3; 2]) -> OrientedBox {
    OrientedBox { centre: 0.5 * (min + max), axis: DVec2::X, half: 0.5 * (max - min) }
}

/// World `number` of a seed: some turned, some very small or large.
///
/// # Errors
/// None of lights that are drawn.
pub fn random(seed: u64, number: u32, wanted: Wanted) -> Result<World, SuiteError> {
    let mut rng = rng(seed, "world", number);
    let drawn = drawn(&mut rng, wanted);
    let degrees = if number % 4 == 3 { rng.random_range(0..90) } else { 0 };
    let scale = [1.0, 1.0, 1.0, 1.0, 1e-3, 1e4][rng.random_range(0..6)];
    Ok(drawn.world(Turn::degrees(degrees), scale)?)
}

impl World {
    /// A technique made ready.
    ///
    /// # Errors
    /// Settings that are refused.
    pub fn make(
        &self,
        technique: &RegionTechnique,
        form: Form,
    ) -> Result<Box<dyn Precuts>, SuiteError> {
        let reference = form == Form::Reference;
        Ok(make(technique, reference, &self.world, &self.tree, &self.occluders)?)
    }

    /// What a direction's face sees past boxes.
    pub fn sight(&self, direction: Direction, solids: &[Solid]) -> Option<Sight<'_>> {
        Sight::new(&self.world, &self.cell, direction, solids, Obstacles::Boxes)
    }

    /// The face of a direction, in its space.
    pub fn face(&self, direction: Direction) -> Option<dapple_many_lights::region::Cuboid> {
        self.cell.face(direction).map(|face| face.cuboid(direction))
    }
}

/// Nodes of a precut.
pub fn nodes_of(of: &mut dyn Precuts, cell: &ViewCell, direction: Direction) -> Vec<u32> {
    let mut nodes = Vec::new();
    of.precut(cell, direction, &mut nodes);
    nodes
}

/// Any setting of a technique's variant: knobs anywhere, all sound, none that costs a gate its time.
pub fn setting(rng: &mut Pcg64, technique: &Technique, variant: &str, form: Form) -> Setting {
    let mut knobs: Knobs =
        technique.knobs.iter().map(|k| (k.name.to_string(), anywhere(rng, k))).collect();
    if let Some(occluders) = knobs.get_mut("occluders") {
        // Boxes around clusters are the thesis's, and hide what is seen; worlds of boxes have no
        // objects beside these.
        *occluders = ["boxes", "runs"][rng.random_range(0..2)].into();
    }
    if let Some(texels) = knobs.get_mut("texels") {
        *texels = [16, 40, 64, 128][rng.random_range(0..4)].into();
    }
    if let Some(rays) = knobs.get_mut("rays") {
        *rays = rng.random_range(1..32).into();
    }
    if let Some(step) = knobs.get_mut("least_step") {
        *step = [0.0, 2.0, 5.0][rng.random_range(0..3)].into();
    }
    Setting { technique: technique.id.into(), variant: variant.into(), form, knobs }
}

/// The case of a city, as small as gates take it.
fn case(scene: &str, seed: u64, width: i64) -> Result<Case, SuiteError> {
    let given: Knobs = [
        ("width", json!(width)),
        ("tau", json!(65_536)),
        ("truth_faces", json!(1)),
        ("truth_lights", json!(1)),
        ("truth_points", json!(8)),
    ]
    .map(|(name, value)| (name.to_string(), value))
    .into();
    Ok(Case {
        problem: SPEC.id.into(),
        scene: scene.into(),
        view: String::new(),
        seed,
        parameters: knob::complete("parameter", SPEC.parameters, &given)?,
    })
}

/// A generated city.
///
/// # Errors
/// None of a city that there is.
pub fn generated(seed: u64) -> Result<RegionCase, SuiteError> {
    RegionCase::prepare(&case("city_small", seed, 32)?)
}

/// Real cities, where the data are at hand.
///
/// # Errors
/// Files that cannot be used.
pub fn real() -> Result<Vec<RegionCase>, SuiteError> {
    let Some(folder) = std::env::var_os(DATA_VARIABLE) else { return Ok(Vec::new()) };
    let files = ["city/delft.city.json", "city/Helsinki.osm.pbf"];
    let there = files.into_iter().filter(|file| std::path::Path::new(&folder).join(file).exists());
    there.map(|file| RegionCase::prepare(&case(&format!("data:{file}"), 0, 16)?)).collect()
}
