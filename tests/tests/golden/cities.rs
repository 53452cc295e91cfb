//! Cities: plans of their layouts, what the camera sees of one from the four points of view, whose
//! pixels they are, what was culled, and view cells.

use dapple_occlusion::camera::{
    CellLimits, Frame, Image, Objects, Readiness, Renderer, Settings, State, Technique, Tree, View,
    city_keys, exact_coverage,
    software::{self, Reference},
    techniques, view_cells,
};
use dapple_scene::{
    Camera, Projection, Scene,
    city::{self, City, Knobs, Part},
};
use dapple_suite::{
    case::Case,
    knob,
    problem::{Form, Prepared, Setting},
    problems::camera_visibility::{SPEC, VisibilityCase},
};
use dapple_tests::golden::{LSB, Picture, Tolerance, assert_golden};
use dapple_trace::{Ray, Tracer};
use glam::DVec3;
use std::sync::Arc;

/// Views by a camera.
const SIZE: [u32; 2] = [160, 90];

/// Plans: 3.25 m a pixel, a little more than the reference city.
const PLAN: [u32; 2] = [480, 80];
const PLAN_M: f64 = 3.25;

/// Distance of the near plane.
const NEAR_M: f64 = 0.1;

/// Share of the image up to which a view cell is not divided.
const CELL_SHARE: f64 = 16_384.0 / (1200.0 * 900.0);

/// Frames before a picture of what a technique drew, so that it knows the view.
const FRAMES: u32 = 8;

const VIEWS: [&str; 4] = ["facade", "close_ended", "street", "birds_eye"];
const LAYOUTS: [(&str, bool); 2] = [("plan", true), ("plan-grid", false)];
const CULLED: [&str; 2] = ["close_ended", "street"];
const CELLS: [&str; 2] = ["street", "birds_eye"];

/// Names and tolerances of this file's goldens.
pub fn goldens() -> Vec<(String, Tolerance)> {
    let mut names: Vec<String> = LAYOUTS.iter().map(|(name, _)| format!("city-{name}")).collect();
    names.extend(VIEWS.iter().map(|view| format!("city-{view}")));
    names.push("city-ids".into());
    names.extend(CULLED.iter().map(|view| format!("city-culled-{view}")));
    names.extend(CELLS.iter().map(|view| format!("city-cells-{view}")));
    names.into_iter().map(|name| (name, LSB)).collect()
}

/// A city and all that is drawn of it: an object is an instance.
struct Town {
    city: City,
    scene: Scene,
    parts: Vec<Part>,
    objects: Arc<Objects>,
    owners: Vec<[u32; 2]>,
}

fn town(brick_offset: bool) -> Town {
    let city = city::generate(&Knobs { brick_offset, ..Knobs::default() }, 1).unwrap();
    let made = city.scene();
    let (objects, owners) = Objects::from_scene(&made.scene, 1024).unwrap();
    assert_eq!(objects.objects.len(), made.parts.len());
    Town { city, scene: made.scene, parts: made.parts, objects: Arc::new(objects), owners }
}

impl Town {
    fn camera(&self, name: &str) -> &Camera {
        self.scene.cameras.iter().find(|c| c.name == name).unwrap()
    }

    fn view(&self, camera: &Camera, [width, height]: [u32; 2]) -> View {
        View::new(camera, &self.objects, width, height, NEAR_M).unwrap()
    }

    /// Everything, drawn.
    fn image(&self, view: &View) -> Image {
        let mut renderer = Reference::new(self.objects.clone(), Readiness::Modelled(0)).unwrap();
        let all: Vec<u32> = (0..self.objects.objects.len() as u32).collect();
        renderer.begin(view).unwrap();
        renderer.draw(&all).unwrap();
        renderer.end().unwrap();
        renderer.image().clone()
    }

    fn tree(&self) -> Tree {
        let keys = city_keys(&self.parts, &self.scene, &self.owners, &self.objects);
        Tree::by_keys(&self.objects, &keys).unwrap()
    }

    fn building(&self, object: u32) -> Option<u32> {
        match self.parts[object as usize] {
            Part::Storey { building, .. } | Part::Roof { building, .. } => Some(building),
            Part::Ground { .. } | Part::Tree { .. } => None,
        }
    }

    /// The object at the centre of every pixel, by rays.
    fn by_rays(&self, camera: &Camera, [width, height]: [u32; 2]) -> Vec<Option<u32>> {
        let tracer = Tracer::build(&self.scene).unwrap();
        let aspect = f64::from(width) / f64::from(height);
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
        pixels
            .map(|[x, y]| {
                let at = |p: u32, of: u32| (f64::from(p) + 0.5) / f64::from(of);
                let (origin, direction) = camera.ray(at(x, width), at(y, height), aspect);
                let hit = tracer.closest(&Ray::new(origin, direction))?;
                Some(self.owners[hit.triangle as usize][0])
            })
            .collect()
    }
}

/// Straight down onto the city, north (-z) up.
fn above() -> Camera {
    Camera {
        name: "plan".into(),
        position: DVec3::Y * 60.0,
        target: DVec3::ZERO,
        up: DVec3::NEG_Z,
        projection: Projection::Orthographic { height_m: PLAN_M * f64::from(PLAN[1]) },
    }
}

/// The object of a pixel.
fn owner(image: &Image, pixel: usize) -> Option<u32> {
    image.ids[pixel][0].checked_sub(1)
}

/// A grey of a number, apart from its neighbours'.
fn grey(number: u32) -> f32 {
    0.1 + 0.85 * (number.wrapping_mul(0x9e37_79b9) >> 24) as f32 / 255.0
}

/// Places in the plane (x, z) of the pixels of a plan.
fn places() -> impl Iterator<Item = [f64; 2]> {
    let at = |p: u32, of: u32| (f64::from(p) + 0.5 - 0.5 * f64::from(of)) * PLAN_M;
    (0..PLAN[1]).flat_map(move |z| (0..PLAN[0]).map(move |x| [at(x, PLAN[0]), at(z, PLAN[1])]))
}

/// Storeys by the layout's own numbers; `None` within a centimetre of a wall, 0 for the ground.
fn storeys(city: &City, [x, z]: [f64; 2]) -> Option<u32> {
    const BESIDE_M: f64 = 0.01;
    let mut found = 0;
    for building in &city.buildings {
        let (min, max) = (building.outer.min, building.outer.max);
        let inside = (x - min.x).min(max.x - x).min(z - min.z).min(max.z - z);
        if inside.abs() < BESIDE_M {
            return None;
        }
        if inside > 0.0 {
            found = (building.eaves_m / 3.0).round() as u32;
        }
    }
    Some(found)
}

/// Heights from above: grounds dark, buildings by storeys.
#[test]
fn plans_show_the_heights_of_the_layout() {
    let mut pictures = Vec::new();
    for (name, brick_offset) in LAYOUTS {
        let town = town(brick_offset);
        let view = town.view(&above(), PLAN);
        let image = town.image(&view);
        let top = view.eye.y + town.objects.origin.y;
        let (mut held, mut values) = ([0_u32; 8], Vec::new());
        for (pixel, place) in places().enumerate() {
            let height = match image.depth[pixel] {
                0.0 => 0.0,
                depth => top - (1.0 - f64::from(depth)) * view.range_m,
            };
            let seen = (height / 3.0).round();
            assert!((height - 3.0 * seen).abs() < 1e-3, "{name}: {height} m at {place:?}");
            if let Some(expected) = storeys(&town.city, place) {
                assert_eq!(seen as u32, expected, "{name}: {place:?}");
                held[expected as usize] += 1;
            }
            let ground = owner(&image, pixel).and_then(|o| match town.parts[o as usize] {
                Part::Ground { ground } => Some(ground),
                _ => None,
            });
            values.push(match ground.map(|g| town.city.grounds[g as usize].kind) {
                Some(city::GroundKind::Street) => 0.1,
                Some(city::GroundKind::Sidewalk) => 0.2,
                Some(_) => 0.0,
                None if seen == 0.0 => 0.0,
                None => 0.3 + 0.1 * seen as f32,
            });
        }
        println!("{name}: pixels by storeys {held:?}");
        assert!(held.iter().all(|count| *count > 500), "{name}: {held:?}");
        pictures.push(Picture::from_values(PLAN[0], PLAN[1], &values));
    }
    assert_ne!(pictures[0], pictures[1]);
    for ((name, _), picture) in LAYOUTS.iter().zip(&pictures) {
        assert_golden(&format!("city-{name}"), picture, LSB);
    }
}

/// Lit by a moon, as CHC++ draws it; the image is that of drawing everything, and nothing that owns
/// a pixel by rays is missing.
#[test]
fn four_points_of_view() {
    for name in VIEWS {
        let given =
            knob::Knobs::from([("width".into(), SIZE[0].into()), ("frames".into(), FRAMES.into())]);
        let case = Case {
            problem: SPEC.id.into(),
            scene: "city".into(),
            view: name.into(),
            seed: 1,
            parameters: knob::complete("parameter", SPEC.parameters, &given).unwrap(),
        };
        let case = VisibilityCase::prepare(&case, None).unwrap();
        assert_eq!(case.size(), SIZE);
        let technique = SPEC.technique("chcpp").unwrap();
        let setting = Setting {
            technique: technique.id.into(),
            variant: technique.variants[0].id.into(),
            form: Form::Cpu,
            knobs: knob::complete("knob", technique.knobs, &knob::Knobs::new()).unwrap(),
        };
        let mut subject = case.subject(&setting).unwrap();
        let checked = subject.check().unwrap();
        assert_eq!(checked.violations, Vec::<String>::new(), "{name}");
        assert_eq!((checked.errors["missed"], checked.errors["wrong_pixels"]), (0.0, 0.0));
        let picture = subject.picture().unwrap().unwrap();
        let apart = picture.truth.iter().zip(&picture.result).filter(|(a, b)| a != b).count();
        println!("{name}: {apart} pixels show another triangle than rays");
        assert!(apart * 40 < picture.truth.len(), "{name}: {apart} pixels differ from rays");
        let result = Picture::from_values(SIZE[0], SIZE[1], &picture.result);
        assert_golden(&format!("city-{name}"), &result, LSB);
    }
}

/// The object of every pixel, held against rays wherever all neighbours are of the same object.
#[test]
fn ids_are_what_rays_meet() {
    let town = town(true);
    let camera = town.camera("street");
    let image = town.image(&town.view(camera, SIZE));
    let rays = town.by_rays(camera, SIZE);
    let (width, height) = (SIZE[0] as usize, SIZE[1] as usize);
    let mut sure = 0;
    for y in 1..height - 1 {
        for x in 1..width - 1 {
            let around = (0..9).map(|i| rays[(y + i / 3 - 1) * width + x + i % 3 - 1]);
            let own = rays[y * width + x];
            if around.into_iter().all(|o| o == own) {
                assert_eq!(owner(&image, y * width + x), own, "pixel {x}, {y}");
                sure += 1;
            }
        }
    }
    println!("{sure} pixels were held against rays");
    assert!(sure * 2 > width * height, "only {sure} pixels lie inside an object");
    let values: Vec<f32> =
        (0..width * height).map(|p| owner(&image, p).map_or(0.0, grey)).collect();
    assert_golden("city-ids", &Picture::from_values(SIZE[0], SIZE[1], &values), LSB);
}

/// What a frame did with an object or, the greatest of its objects', a building.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Fate {
    Outside,
    Culled,
    Drawn,
}

impl Fate {
    fn grey(self) -> f32 {
        match self {
            Self::Outside => 0.3,
            Self::Culled => 0.6,
            Self::Drawn => 1.0,
        }
    }
}

/// By object: what CHC++ did in the last of some frames of a still view.
fn fates(town: &Town, camera: &Camera) -> Vec<Fate> {
    let view = town.view(camera, SIZE);
    let (tree, settings) = (town.tree(), Settings::new(Technique::ChcPlusPlus));
    let mut renderer = Reference::new(town.objects.clone(), Readiness::Modelled(64)).unwrap();
    let (mut state, mut out) = (State::new(&tree), Frame::default());
    for _ in 0..FRAMES {
        let objects = &town.objects;
        techniques::frame(&settings, objects, &tree, &view, &mut state, &mut renderer, &mut out)
            .unwrap();
    }
    let fate = |bounds| if view.sees(bounds) { Fate::Culled } else { Fate::Outside };
    let mut fates: Vec<Fate> = town.objects.objects.iter().map(|o| fate(&o.bounds)).collect();
    for object in out.drawn {
        fates[object as usize] = fates[object as usize].max(Fate::Drawn);
    }
    fates
}

/// Buildings from above: drawn, culled, and outside the frustum. Streets are black, so that the
/// camera's is seen as one.
#[test]
fn what_was_culled() {
    let town = town(true);
    let plan = town.image(&town.view(&above(), PLAN));
    for name in CULLED {
        let camera = town.camera(name);
        let objects = fates(&town, camera);
        let mut buildings = vec![Fate::Outside; town.city.buildings.len()];
        for (object, fate) in objects.iter().enumerate() {
            if let Some(building) = town.building(object as u32) {
                let own = &mut buildings[building as usize];
                *own = (*own).max(*fate);
            }
        }
        for object in town.by_rays(camera, SIZE).into_iter().flatten() {
            assert_eq!(objects[object as usize], Fate::Drawn, "{name}: object {object} is seen");
        }
        let count = |fate| buildings.iter().filter(|f| **f == fate).count();
        let counts = [Fate::Drawn, Fate::Culled, Fate::Outside].map(count);
        println!("{name}: buildings drawn, culled, outside {counts:?}");
        assert!(counts.iter().all(|c| *c > 5) && counts[1] > 5 * counts[0], "{name}: {counts:?}");
        let grey = |pixel| match owner(&plan, pixel).and_then(|o| town.building(o)) {
            Some(building) => buildings[building as usize].grey(),
            None => 0.0,
        };
        let values: Vec<f32> = (0..plan.ids.len()).map(grey).collect();
        let picture = Picture::from_values(PLAN[0], PLAN[1], &values);
        assert_golden(&format!("city-culled-{name}"), &picture, LSB);
    }
}

/// View cells, a grey each: no cell that can be divided covers more than the threshold.
#[test]
fn view_cells_cover_about_as_many_pixels_each() {
    let town = town(true);
    let tree = town.tree();
    for name in CELLS {
        let image = town.image(&town.view(town.camera(name), SIZE));
        let pixels = software::owners(&image, town.objects.objects.len());
        let mut coverage = vec![0; tree.nodes.len()];
        exact_coverage(&tree, &pixels, &mut coverage).unwrap();
        let visible: Vec<u32> =
            (0..pixels.len() as u32).filter(|o| pixels[*o as usize] > 0).collect();
        let tau_px = (CELL_SHARE * f64::from(SIZE[0] * SIZE[1])).round() as u32;
        let limits = CellLimits { tau_px, most_level: u32::MAX };
        let cells = view_cells(&tree, &coverage, &tree.levels(), &visible, limits).unwrap();
        let mut cell_of = vec![None; pixels.len()];
        for (index, cell) in cells.cells.iter().enumerate() {
            let covered: u32 = cells.objects_of(index).iter().map(|o| pixels[*o as usize]).sum();
            assert!(covered <= tau_px || tree.is_leaf(cell.node), "{name}: {covered} pixels");
            for object in cells.objects_of(index) {
                assert_eq!(cell_of[*object as usize].replace(index as u32), None);
            }
        }
        println!("{name}: {} cells of {} objects", cells.cells.len(), visible.len());
        assert!((10..visible.len() / 2).contains(&cells.cells.len()), "{name}");
        let shade = |pixel| match owner(&image, pixel) {
            Some(object) => grey(cell_of[object as usize].unwrap()),
            None => 0.0,
        };
        let values: Vec<f32> = (0..image.ids.len()).map(shade).collect();
        let picture = Picture::from_values(SIZE[0], SIZE[1], &values);
        assert_golden(&format!("city-cells-{name}"), &picture, LSB);
    }
}

/// Control: a camera elsewhere culls what this one sees.
#[test]
fn another_view_culls_what_is_seen_here() {
    let town = town(true);
    let elsewhere = fates(&town, town.camera("facade"));
    let seen = town.by_rays(town.camera("street"), SIZE);
    let missed = seen.into_iter().flatten().filter(|o| elsewhere[*o as usize] != Fate::Drawn);
    assert!(missed.count() > 5000);
}
