//! The truth of shadow filtering, held against what it is not made of.

use dapple_suite::{problems::shadow_filtering::ShadowCase, scene};
use dapple_trace::Surface;

/// Rays a receiver and axis, as the problem's default.
const GRID: u32 = 8;

/// The receivers as surfaces, found again.
fn surfaces(case: &ShadowCase<'_>) -> Vec<Option<Surface>> {
    let camera = scene::camera(case.scene(), "").unwrap();
    let [width, height] = case.size();
    let items = dapple_trace::item_buffer(case.tracer(), &camera, width, height);
    let all = dapple_trace::surfaces(case.tracer(), &items);
    all.into_iter().zip(case.mask()).map(|(s, m)| s.filter(|_| *m)).collect()
}

/// The case's truth is what the tracer gives now, and agrees with rays that go the other way, from
/// the receiver's own point towards the light.
pub fn check(case: &ShadowCase<'_>, seed: u64) {
    let surfaces = surfaces(case);
    let (tracer, view) = (case.tracer(), case.view());
    let now = dapple_trace::filtered_visibility_all(
        tracer,
        view,
        &surfaces,
        case.footprint(),
        GRID,
        seed,
    );
    // The truth may come from a cache: a cache must not hide a change.
    let stale = |((a, b), m): ((&f64, &f32), &bool)| *m && *a as f32 != *b;
    let changed = now.iter().zip(case.truth()).zip(case.mask()).filter(|p| stale(*p)).count();
    assert_eq!(changed, 0, "the truth is not what the tracer gives");

    let points =
        dapple_trace::light_visibility_all(tracer, &surfaces, &case.scene().lights[0], 1, 0);
    let (mut sure, mut wrong, mut counted, mut difference) = (0, 0, 0, 0.0);
    for ((truth, point), mask) in case.truth().iter().zip(&points).zip(case.mask()) {
        if *mask {
            counted += 1;
            difference += f64::from(*truth) - point;
            if *truth == 0.0 || *truth == 1.0 {
                sure += 1;
                wrong += usize::from(f64::from(*truth) != *point);
            }
        }
    }
    assert!(counted > 5000 && 2 * sure > counted, "{sure} of {counted} receivers");
    // Where all 64 rays of a window agree, the ray through its middle does too, but for slits
    // and slats that fall between the rays.
    let share = f64::from(wrong as u32) / f64::from(sure as u32);
    println!("centre rays: {wrong} of {sure} sure receivers differ");
    assert!(share <= 0.005, "{wrong} of {sure} sure receivers differ from their centre's ray");
    // A box filter moves light, it neither makes nor takes any.
    let mean = difference / f64::from(counted);
    println!("mean of truth less mean of centre rays: {mean:.5}");
    assert!(mean.abs() <= 0.01, "filtering changes the mean visibility by {mean}");
}

/// Under the half plane the lit share of a window of side w at x is 0.5 + x / w.
pub fn check_half_plane(case: &ShadowCase<'_>) {
    let view = case.view();
    for axis in [view.right, view.down] {
        assert!(axis.x.abs() == 1.0 || axis.z.abs() == 1.0, "the window is not along x and z");
    }
    let side = case.footprint() * view.side_m();
    let (mut counted, mut penumbra, mut squares, mut most) = (0, 0, 0.0, 0.0_f64);
    for (surface, truth) in surfaces(case).iter().zip(case.truth()) {
        let Some(surface) = surface else { continue };
        let p = surface.position;
        // Away from the occluder's other three edges.
        if p.y.abs() < 1e-6 && p.z.abs() < 2.9 && p.x > -2.9 {
            let lit = (0.5 + p.x / side).clamp(0.0, 1.0);
            let error = f64::from(*truth) - lit;
            counted += 1;
            penumbra += usize::from(lit > 0.0 && lit < 1.0);
            squares += error * error;
            most = most.max(error.abs());
        }
    }
    let rmse = (squares / f64::from(counted)).sqrt();
    println!("half plane: {penumbra} of {counted} in penumbra, rmse {rmse:.5}, largest {most:.4}");
    assert!(counted > 5000 && penumbra > 200, "{penumbra} of {counted} receivers in penumbra");
    // The edge crosses one of the eight columns of strata: its eight rays are lit by chance, so
    // the lit share's deviation is at most sqrt(8 / 4) / 64 = 0.022, and 8 / 64 for sure.
    assert!(rmse <= 0.022 && most <= 0.125, "rmse {rmse}, largest {most}");
}
