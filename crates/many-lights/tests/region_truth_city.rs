//! Techniques against the triangles of a generated city: what its occluders hide, its walls hide.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use dapple_many_lights::region::truth::{Agreement, Obstacles, Sight, false_culls, kept, seen};
use dapple_many_lights::region::{
    Direction, FacadeCluster, OccluderMode, Occluders, Precuts, RegionTechnique, Sampled, Surface,
    Turn, ViewCell, make,
};
use dapple_many_lights::tree::city::{Levels, keys};
use dapple_many_lights::{LightTree, World, worlds};
use dapple_scene::generate;
use dapple_trace::Tracer;
use glam::{DVec2, DVec3};
use std::sync::{Arc, LazyLock};

struct Town {
    world: Arc<World>,
    tree: Arc<LightTree>,
    occluders: Arc<Occluders>,
    /// Street fronts of some buildings.
    cells: Vec<(ViewCell, Direction)>,
}

/// Four blocks; made once.
static TOWN: LazyLock<Town> = LazyLock::new(|| {
    let city = generate::city_of("city_small", 1).unwrap();
    let origin = DVec3::ZERO;
    let (lights, paths) = keys(&city, origin, Levels::default());
    let tree = Arc::new(LightTree::by_keys(&lights, &paths).unwrap());
    let mut world = worlds::cloud(&worlds::Cloud { lights: 1, ..worlds::Cloud::default() }).world;
    world.lights = lights;
    world.occluders = Some(Arc::new(Tracer::build(&city.scene().scene).unwrap()));
    let occluders = Arc::new(Occluders::of_city(&city, origin));
    let cell = |building: usize| {
        let building = &city.buildings[building];
        let facade = building.facades.iter().find(|f| !f.party)?;
        let heights = [building.base_m, building.eaves_m];
        let wall = Surface::wall(facade.from, facade.to, heights, DVec3::ONE);
        let cell = ViewCell::around(&[wall], Turn::NONE);
        let along = facade.to - facade.from;
        let out = DVec2::new(-along.y, along.x);
        let ahead = |d: &Direction| DVec2::new(d.vector().x, d.vector().z).dot(out);
        let direction = Direction::ALL.into_iter().max_by(|a, b| ahead(a).total_cmp(&ahead(b)))?;
        Some((cell, direction))
    };
    let cells = (0..city.buildings.len()).step_by(17).filter_map(cell).collect();
    Town { world: Arc::new(world), tree, occluders, cells }
});

fn technique(technique: &RegionTechnique) -> Box<dyn Precuts> {
    make(technique, false, &TOWN.world, &TOWN.tree, &TOWN.occluders).unwrap()
}

fn sight(cell: &ViewCell, direction: Direction) -> Sight<'_> {
    let turned = TOWN.occluders.turned(cell.turn, OccluderMode::Leaf);
    let triangles = Obstacles::Triangles(&TOWN.world);
    Sight::new(&TOWN.world, cell, direction, &turned.solids, triangles).unwrap()
}

/// Everything that is found of a technique over all cells: false culls at `threshold`, and how many
/// lights were culled, with so many rays.
fn judged(settings: &RegionTechnique, threshold: f64) -> (usize, u64, u64) {
    let mut technique = technique(settings);
    let mut nodes = vec![];
    let (mut found, mut culled, mut rays) = (0, 0, 0);
    for (cell, direction) in &TOWN.cells {
        technique.precut(cell, *direction, &mut nodes);
        let of = false_culls(&sight(cell, *direction), &TOWN.tree, &nodes, threshold, (60, 1));
        (found, culled, rays) = (found + of.found.len(), culled + of.culled, rays + of.rays);
    }
    (found, culled, rays)
}

fn facade_cluster(occluders: OccluderMode, threshold: f64) -> RegionTechnique {
    let settings = FacadeCluster { occluders, threshold, ..FacadeCluster::default() };
    RegionTechnique::FacadeCluster(settings)
}

#[test]
fn sound_techniques_cull_nothing_that_the_triangles_let_through() {
    assert!(TOWN.cells.len() >= 8);
    let threshold = 1.0 / 1020.0;
    let judged = [
        ("leaf", judged(&facade_cluster(OccluderMode::Leaf, 0.0), 0.0)),
        ("runs", judged(&facade_cluster(OccluderMode::ContiguousMin, 0.0), 0.0)),
        ("threshold", judged(&facade_cluster(OccluderMode::Leaf, threshold), threshold)),
        ("raster", judged(&RegionTechnique::ExtendedProjection { texels: 128 }, 0.0)),
    ];
    eprintln!("false culls, culled, rays: {judged:?}");
    for (name, (found, culled, rays)) in judged {
        assert_eq!(found, 0, "{name}");
        assert!(culled > 10_000 && rays > 5_000, "{name}: {culled} culled, {rays} rays");
    }
}

/// Negative control: the thesis's boxes fill streets, and the search finds out.
#[test]
fn boxes_around_clusters_are_found_out() {
    let (found, culled, _) = judged(&facade_cluster(OccluderMode::BoundingBoxes, 0.0), 0.0);
    eprintln!("{found} false culls of {culled}");
    assert!(found > 0);
}

#[test]
fn techniques_beside_the_truth() {
    let sampled = |rays| RegionTechnique::Sampled(Sampled { rays, seed: 1 });
    let techniques = [
        ("facade-cluster", facade_cluster(OccluderMode::Leaf, 0.0)),
        ("raster 64", RegionTechnique::ExtendedProjection { texels: 64 }),
        ("raster 256", RegionTechnique::ExtendedProjection { texels: 256 }),
        ("1 ray", sampled(1)),
        ("16 rays", sampled(16)),
    ];
    let lights = 0..TOWN.world.lights.len() as u32;
    let found = techniques.map(|(name, settings)| {
        let mut technique = technique(&settings);
        let (mut nodes, mut all) = (vec![], Agreement::default());
        for (cell, direction) in &TOWN.cells {
            let sight = sight(cell, *direction);
            let ahead: Vec<u32> = lights.clone().filter(|l| sight.may_be_lit_by(*l, 0.0)).collect();
            technique.precut(cell, *direction, &mut nodes);
            let kept = kept(&TOWN.tree, &nodes);
            let truth = seen(&sight, &ahead, 4, 2).sightings;
            let pairs = ahead.iter().zip(&truth).map(|(l, s)| (s.is_some(), kept[*l as usize]));
            all += Agreement::of(pairs);
        }
        eprintln!("{name}: {all:?} tightness {:.3}", all.tightness());
        all
    });
    let [cluster, coarse, fine, few, many] = found;
    for sound in [cluster, coarse, fine] {
        assert_eq!(sound.seen_culled, 0);
        assert!(sound.tightness() > 0.3, "{sound:?}");
    }
    assert!(fine.tightness() > coarse.tightness());
    assert!(few.false_hidden() > many.false_hidden());
    assert_eq!((few.hidden_kept, many.hidden_kept), (0, 0));
}
