//! Light lists: what reach and caps leave out.

use super::{hard::FORMS, input};
use crate::{
    SuiteError,
    problem::{Form, Setting},
    problems::many_lights::SPEC,
    verify::{About, Gate, GateContext, Tally, gate},
};
use dapple_many_lights::{
    Clustered, Emission, Light, LightTree, Point, Shaded, World,
    bound::{self, Region, packed},
    capped,
    clustered::{self, Grid, Hierarchy, cells, reach_m},
    cut::tile,
    radiance,
    worlds::{Cloud, cloud},
};
use glam::{DVec3, Vec3};
use rand::RngExt;
use serde_json::json;
use std::f64::consts::PI;

const CLUSTERED: &str = "clustered";
const CAPPED: &str = "capped";

/// Lights of a world, and lights beyond a cap.
const LIGHTS: u32 = 256;

pub fn gates() -> Vec<Gate> {
    let about = |technique, name, statement, fault| About { technique, name, statement, fault };
    vec![
        gate(
            about(
                CLUSTERED,
                "none missing",
                "no light within reach of a point is missing from its cell's list, by either way \
                 of listing",
                "cells end half way to their farthest point",
            ),
            missing,
        ),
        gate(
            about(
                CLUSTERED,
                "left out",
                "an image lacks at most the cutoff for each light that does not reach, a light that \
                 fades gives no more than one that is cut off, and that no more than all",
                "lights reach half as far",
            ),
            left_out,
        ),
        gate(
            about(
                CAPPED,
                "strongest",
                "the lights chosen for a tile are those with the largest bounds over it, as if every \
                 one were bounded",
                "one light fewer is asked for",
            ),
            strongest,
        ),
        gate(
            about(
                CAPPED,
                "row 46 beyond the cap",
                "the error grows with every light beyond the cap, and there is none up to it",
                "the cap grows with the lights",
            ),
            beyond,
        ),
    ]
}

fn missing(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..input::cases(context, 6, faulty) {
        let world = input::world(context.seed, number);
        let mut rng = input::rng(context.seed, "missing", number);
        let settings = Clustered {
            cutoff: 10.0_f64.powf(rng.random_range(-4.0..-1.0)),
            tile: rng.random_range(1..40),
            slices: rng.random_range(1..30),
            window: false,
        };
        for frame in &world.frames {
            let grid = Grid::of(frame, &settings)?;
            let mut cells = cells(&grid, frame);
            if faulty {
                for cell in cells.iter_mut().filter(|cell| !cell.is_empty()) {
                    cell.max = 0.5 * (cell.min + cell.max);
                }
            }
            let lists = clustered::lists(&world, &cells, settings.cutoff);
            let hierarchy = Hierarchy::new(&world.lights, settings.cutoff);
            let there = frame.points.iter().enumerate().filter(|(_, point)| point.is_there());
            for (pixel, point) in there {
                let cell = grid.cell_of(frame, pixel);
                let mut found = Vec::new();
                hierarchy.list(&cells[cell], &mut found);
                let place = |&i: &u32| hierarchy.lights[i as usize].light;
                let found: Vec<u32> = found.iter().map(place).collect();
                for (index, light) in (0_u32..).zip(&world.lights) {
                    let reach = reach_m(light, settings.cutoff);
                    let distance = light.position.distance(point.position.as_dvec3());
                    // At the very reach f32 decides by its own distance.
                    let share = towards(point, light);
                    let near = reach > 0.0 && distance <= reach && share > 0.0;
                    let clear = near && distance < (1.0 - 1e-5) * reach && share > 1e-4;
                    tally.check(!near || lists.of(cell).contains(&index), || {
                        format!("{settings:?}: light {index} is missing at pixel {pixel}")
                    });
                    tally.check(!clear || found.contains(&index), || {
                        format!("{settings:?}: f32 misses light {index} at pixel {pixel}")
                    });
                }
            }
        }
    }
    Ok(tally)
}

/// Share of a light's intensity that leaves it towards a point.
fn towards(point: &Point, light: &Light) -> f64 {
    if light.emission == Emission::Directional {
        return 1.0;
    }
    let to_light = light.position - point.position.as_dvec3();
    let normal = to_light.normalize_or_zero().as_vec3();
    let facing = Point { normal, albedo: Vec3::ONE, ..*point };
    let of =
        |emission| radiance(&facing, &Light { emission, intensity: DVec3::ONE, ..*light }, 1.0).x;
    let whole = of(Emission::Omni);
    if whole > 0.0 { of(light.emission) / whole } else { 0.0 }
}

/// A frame of a technique at its default settings, but for those given.
fn lit(
    given: &input::Given<'_>,
    technique: &str,
    variant: &str,
    form: Form,
    knobs: &[(&str, serde_json::Value)],
) -> Result<Shaded, SuiteError> {
    let setting = input::default_setting(SPEC.technique(technique)?, form, knobs)?;
    let setting = Setting { variant: variant.into(), ..setting };
    let frames = given.frames(&setting, 0)?;
    frames.into_iter().next().ok_or_else(|| SuiteError::Internal("no frame".into()))
}

fn left_out(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..input::cases(context, 4, faulty) {
        let given = input::Given::new(input::world(context.seed, number), context.seed, None)?;
        let cutoff = [1e-4, 1e-3, 1e-2, 0.1][number as usize % 4];
        let used = if faulty { 4.0 * cutoff } else { cutoff };
        let world = &given.world;
        for form in [Form::Reference, Form::Cpu] {
            let of = |variant| lit(&given, CLUSTERED, variant, form, &[("cutoff", json!(used))]);
            let (window, cut) = (of("window")?, of("cut")?);
            let all = input::truth(world, 0);
            let there = world.frames[0].points.iter().enumerate().filter(|(_, p)| p.is_there());
            for (pixel, point) in there {
                let (faded, found) =
                    (window.radiance[pixel].as_dvec3(), cut.radiance[pixel].as_dvec3());
                let rounding = 1e-4 * all[pixel].max_element() + 1e-7;
                let ordered = (found - faded).min_element() >= -rounding
                    && (all[pixel] - found).min_element() >= -rounding;
                tally.check(ordered, || {
                    format!("{form}, pixel {pixel}: {faded}, {found}, {}", all[pixel])
                });
                let away = world.lights.iter().filter(|light| {
                    let distance = light.position.distance(point.position.as_dvec3());
                    distance > (1.0 - 1e-5) * reach_m(light, cutoff)
                });
                let most = cutoff * away.count() as f64;
                let lack = (all[pixel] - found).max_element();
                tally.within(lack, most + rounding, || format!("{form}, pixel {pixel} lacks"));
            }
        }
    }
    Ok(tally)
}

fn strongest(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..input::cases(context, 6, faulty) {
        let world = input::world(context.seed, number);
        let mut rng = input::rng(context.seed, "strongest", number);
        let tree = LightTree::median(&world.lights)?;
        let groups = capped::Groups::new(&tree.pack());
        let clamp = packed::clamp_squared(world.clamp_m);
        let frame = &world.frames[0];
        let mut choice = capped::Choice::default();
        let (columns, rows) = tile::tiles(frame.width, frame.height);
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |c| (row, c))) {
            let pixels = tile::pixels(frame.width, frame.height, column, row);
            let points = pixels.map(|pixel| &frame.points[pixel]);
            let (Some(over), Some(packed_over)) =
                (Region::of(points.clone()), packed::PackedRegion::of(points))
            else {
                continue;
            };
            let most = rng.random_range(1..world.lights.len());
            let asked = if faulty { most - 1 } else { most };
            capped::strongest(&groups, &packed_over, asked, clamp, &mut choice);
            let bound = |light: u32| {
                let leaf = &tree.nodes[tree.leaves[light as usize] as usize];
                bound::region(FORMS[1], leaf, &over, world.clamp_m)
            };
            // By bounds rather than by lights: those within rounding of the last are as good.
            let mut all: Vec<f64> = (0..world.lights.len() as u32).map(bound).collect();
            all.sort_by(|a, b| b.total_cmp(a));
            all.truncate(most);
            let mut ours: Vec<f64> = choice.lights.iter().map(|&light| bound(light)).collect();
            ours.sort_by(|a, b| b.total_cmp(a));
            ours.resize(most.max(ours.len()), 0.0);
            for (ours, best) in ours.iter().zip(&all) {
                let off = (ours - best).abs();
                tally.check(off <= 1e-3 * best + 1e-12, || {
                    format!("tile {column}, {row}, {most} lights: {ours} rather than {best}")
                });
            }
        }
    }
    Ok(tally)
}

fn beyond(context: &GateContext<'_>, faulty: bool) -> Result<Tally, SuiteError> {
    let mut tally = Tally::default();
    for number in 0..input::cases(context, 2, faulty) {
        let all = cloud(&Cloud {
            lights: LIGHTS,
            // What shines to all sides: each light beyond the cap is missed somewhere.
            emissions: vec![
                [Emission::Omni, Emission::Spot { half_angle_rad: PI }][number as usize % 2],
            ],
            seed: dapple_many_lights::sample::hash(context.seed as u32) ^ number,
            size: [24, 17],
            ..Cloud::default()
        });
        let mut before = 0.0;
        for count in [32, 48, 64, 128, LIGHTS as usize] {
            let lights = all.world.lights[..count].to_vec();
            let given =
                input::Given::new(World { lights, ..all.world.clone() }, context.seed, None)?;
            let most = if faulty { count } else { 32 };
            let shaded = lit(&given, CAPPED, "plain", Form::Cpu, &[("most", json!(most))])?;
            let truth = input::truth(&given.world, 0);
            let squares: f64 = shaded
                .radiance
                .iter()
                .zip(&truth)
                .map(|(found, exact)| (found.as_dvec3() - *exact).length_squared())
                .sum();
            let error = (squares / (3 * truth.len()) as f64).sqrt();
            let mean = truth.iter().sum::<DVec3>().element_sum() / (3 * truth.len()) as f64;
            let holds =
                if count == 32 { error <= 1e-4 * mean } else { error > before + 1e-5 * mean };
            tally.check(holds, || format!("{count} lights: error {error} after {before}"));
            before = error;
        }
    }
    Ok(tally)
}
