//! What is refused, by name.

use super::*;
use crate::camera::Query;

fn refusal(world: Objects) -> String {
    let world = Arc::new(world);
    let by_fast = Fast::new(world.clone(), NOW).unwrap_err().to_string();
    assert_eq!(Reference::new(world, NOW).unwrap_err().to_string(), by_fast);
    by_fast
}

fn broken(change: impl Fn(&mut Objects)) -> String {
    let mut world = Objects::clone(&masked(&objects(&soup(1, 12, 2), 3)));
    change(&mut world);
    refusal(world)
}

#[test]
fn broken_objects_are_refused_by_name() {
    assert!(broken(|w| w.templates[1].positions[4].y = f32::NAN).contains("template 1: corner 4"));
    assert!(broken(|w| w.templates[0].triangles[2][1] = 9).contains("template 0: triangle 2"));
    assert!(broken(|w| w.objects[3].template = 7).contains("object 3"));
    assert!(broken(|w| w.objects[2].translation.x = f32::INFINITY).contains("object 2"));
    assert!(broken(|w| w.templates[2].mask = Some(1)).contains("mask 1 is not there"));
    assert!(broken(|w| w.masks[0].words.clear()).contains("0 words for 5 x 5"));
    assert!(broken(|w| w.masks[0].width = 0).contains("0 x 5"));
    assert!(broken(|w| w.templates[0].uvs.truncate(3)).contains("3 texture coordinates"));
    let polled = Fast::new(Arc::new(Objects::default()), Readiness::Polled).unwrap_err();
    assert!(polled.to_string().contains("no device"));
}

#[test]
fn commands_out_of_place_are_refused() {
    let world = objects(&soup(1, 12, 2), 3);
    let view = straight(&world, 8, 8);
    let renderers: [Box<dyn Renderer>; 2] = [
        Box::new(Reference::new(world.clone(), NOW).unwrap()),
        Box::new(Fast::new(world.clone(), NOW).unwrap()),
    ];
    for mut renderer in renderers {
        assert!(renderer.draw(&[0]).is_err());
        assert!(renderer.ask(&[], &[]).is_err());
        for (width, height) in [(0, 8), (8, 0), (u32::MAX, 8), (8, 16385)] {
            let mut view = view.clone();
            (view.width, view.height) = (width, height);
            assert!(renderer.begin(&view).is_err());
        }
        renderer.begin(&view).unwrap();
        let error = renderer.draw(&[1, 4]).unwrap_err().to_string();
        assert!(error.contains("object 4: there are 4 objects"), "{error}");
        let error = renderer.ask(&[Bounds::EMPTY], &[]).unwrap_err().to_string();
        assert!(error.contains("box 0"), "{error}");
        let error = renderer.ask(&[], &[Query { boxes: 0..1 }]).unwrap_err().to_string();
        assert!(error.contains("query 0"), "{error}");
        assert!(renderer.collect(&mut Vec::new()).is_err());
    }
}

#[test]
fn placements_beyond_floats_draw_nothing_and_do_not_panic() {
    let mut world = Objects::clone(&objects(&soup(1, 12, 2), 3));
    for object in &mut world.objects {
        object.linear = Mat3::from_diagonal(Vec3::splat(3e38));
        object.bounds = Bounds { min: Vec3::splat(-1e30), max: Vec3::splat(1e30) };
    }
    let world = Arc::new(world);
    let view = straight(&objects(&soup(1, 12, 2), 3), 16, 16);
    for image in [reference(&world, &view).image(), fast(&world, &view).image()] {
        assert!(image.depth.iter().all(|d| d.is_finite()));
    }
}
