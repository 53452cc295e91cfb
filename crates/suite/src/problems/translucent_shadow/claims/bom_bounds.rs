//! H5.4 and H5.5: where both ends of a ray come from, and what lies between them.

use super::{
    support::{Method, SCENES, bom, dom, frame_ns, still},
    verdict::{all_of, figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Figure, Judged, Verdict},
    problems::translucent_shadow::subject_gpu,
};
use dapple_gpu::Gpu;
use dapple_opacity_maps::{
    Code, EndMap, Fragment, Fragments, NO_OPAQUE, Opaque,
    code::TexelCode,
    layered::{LayeredCode, placement::Place},
};
use dapple_scene::generate::{SPHERE_CLOUD, Volume};

/// A last place of 32-bit floats next to 1.
const LAST_PLACE: f64 = f32::EPSILON as f64;

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "voicu-H5.4",
            statement: "The end map drawn with near and far plane swapped is the one of depth \
                        comparison GREATER",
            place: "Voicu 2011, section 5.1, figure 5.1.1",
            method: "every texel of ten scenes: 1 minus the least of 1 - d against the greatest d, \
                     in 32-bit floats; and on an adapter, software or not, the ends that five \
                     routes rasterise (GREATER, swapped planes, flipped range, MAX blending, \
                     atomics) on grass, tree and hair. Same if no end differs by more than a last \
                     place of 1 (2^-23): a difference of two depths in 0..1 rounds by half of it \
                     at most, twice",
            judge: Box::new(end_maps),
        },
        Claim {
            id: "voicu-H5.5",
            statement: "Layers between bounds follow both surfaces; deep layers follow the front \
                        alone",
            place: "Voicu 2011, section 5, figure 5.1",
            method: "a ball of evenly spaced fragments, and the generated ball of squares, 8 layers. \
                     Depths of layer boundaries at u = 1/4, 1/2, 3/4 (deep: of the same share of a \
                     diameter) against the ball's front over all rays: the slope of a straight fit. \
                     A ball's front and back are mirrored, so bounds predict 1 - 2u: front, flat, \
                     back. Follows: within 0.1 of that. The front alone: every deep slope within \
                     0.1 of 1. Reproduced if both hold on both balls",
            judge: Box::new(surfaces),
        },
    ]
}

/// Greatest differences of ends.
fn same_ends(differences: &[f64]) -> Verdict {
    let same = differences.iter().all(|d| *d <= LAST_PLACE);
    if same && !differences.is_empty() { Verdict::Reproduced } else { Verdict::Refuted }
}

/// The swapped planes' end against the greatest depth, over all texels.
fn mirrored(fragments: &Fragments) -> f64 {
    let of = |texel: usize| {
        let items = fragments.texel(texel);
        let last = items.iter().map(|f| f.depth).fold(f32::NEG_INFINITY, f32::max);
        let mirrored = items.iter().map(|f| 1.0 - f.depth).fold(f32::INFINITY, f32::min);
        if items.is_empty() { 0.0 } else { f64::from((1.0 - mirrored - last).abs()) }
    };
    (0..fragments.texels()).map(of).fold(0.0, f64::max)
}

/// Differences of four routes on the device from comparison GREATER.
fn rasterised(gpu: &Gpu, figures: &mut Vec<Figure>) -> Result<Vec<f64>, SuiteError> {
    let mut differences = Vec::new();
    for scene in ["grass", "tree", "hair"] {
        let still = still(scene)?;
        let bounds = |end_map| -> Result<Vec<[f32; 2]>, SuiteError> {
            let method = bom(4).with(|layered| layered.end_map = end_map);
            let renderer = still.renderer(gpu, &method)?;
            frame_ns(gpu, &renderer)?;
            renderer.read_bounds(gpu).map_err(subject_gpu::refused)
        };
        let greater = bounds(EndMap::Greater)?;
        for (name, end_map) in [
            ("swapped planes", EndMap::Swapped),
            ("flipped range", EndMap::RangeFlip),
            ("MAX blending", EndMap::MaxBlend),
            ("atomics", EndMap::Atomic),
        ] {
            let other = bounds(end_map)?;
            let apart = |(a, b): (&[f32; 2], &[f32; 2])| f64::from((a[1] - b[1]).abs());
            let most = greater.iter().zip(&other).map(apart).fold(0.0, f64::max);
            let most = if greater.len() == other.len() { most } else { f64::INFINITY };
            figures.push(figure(format!("{scene}, {name} on the adapter: from GREATER"), most, ""));
            differences.push(most);
        }
        let covered = greater.iter().filter(|b| b[1] > b[0]).count() as f64;
        figures.push(figure(format!("{scene}: texels with two ends"), covered, ""));
    }
    Ok(differences)
}

fn end_maps(context: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut differences) = (Vec::new(), Vec::new());
    for scene in SCENES {
        let difference = mirrored(&*still(scene)?.fragments(&bom(4))?);
        figures.push(figure(format!("{scene}: swapped planes from greatest"), difference, ""));
        differences.push(difference);
    }
    let on = match context.gpu {
        Some(gpu) => {
            differences.extend(rasterised(gpu, &mut figures)?);
            "by arithmetic and as rasterised"
        }
        None => "by arithmetic; there is no adapter to rasterise on",
    };
    let most = differences.iter().copied().fold(0.0, f64::max);
    let because = format!("ends differ by at most {most:.1e} {on}");
    Ok(judged(same_ends(&differences), because, figures))
}

/// Slopes of boundaries at the three shares, bounding and deep.
#[derive(Clone, Copy, Debug)]
struct Slopes {
    bounding: [f64; 3],
    deep: [f64; 3],
}

/// Shares of the way through at which boundaries are looked for.
const SHARES: [f64; 3] = [0.25, 0.5, 0.75];

/// Layers: each of [`SHARES`] is a boundary.
const LAYERS: u32 = 8;

fn follow(balls: &[Slopes]) -> Verdict {
    // Written so that a NaN is refused.
    let near = |got: f64, expected: f64| (got - expected).abs() <= 0.1;
    let both = |s: &Slopes| {
        let follows = s.bounding.iter().zip(SHARES).all(|(got, u)| near(*got, 1.0 - 2.0 * u));
        follows && s.deep.iter().all(|got| near(*got, 1.0))
    };
    let holds: Vec<bool> = balls.iter().map(both).collect();
    if holds.is_empty() || holds.contains(&false) { Verdict::Refuted } else { Verdict::Reproduced }
}

/// A ball's place in a map: centre, and radius in map coordinates and in depth.
#[derive(Clone, Copy)]
struct Ball {
    u: f64,
    v: f64,
    z: f64,
    radius_uv: f64,
    radius_z: f64,
}

impl Ball {
    /// Depth of its front through a texel's centre; the rim, where a ray is hardly in it, is left
    /// out.
    fn front(&self, texel: usize, side: u32) -> Option<f64> {
        let centre = |i: usize| (i as f64 + 0.5) / f64::from(side);
        let (x, y) = (texel % side as usize, texel / side as usize);
        let (du, dv) =
            ((centre(x) - self.u) / self.radius_uv, (centre(y) - self.v) / self.radius_uv);
        let height = 1.0 - du * du - dv * dv;
        (height > 0.1).then(|| self.z - self.radius_z * height.sqrt())
    }
}

/// Evenly spaced fragments on the chords of a ball, both ends among them.
fn even_ball(side: u32) -> (Fragments, Ball) {
    const STEPS: u32 = 32;
    let ball = Ball { u: 0.5, v: 0.5, z: 0.5, radius_uv: 0.45, radius_z: 0.4 };
    let texels = side as usize * side as usize;
    let mut out = Fragments {
        width: side,
        height: side,
        starts: vec![0],
        items: Vec::new(),
        opaque: vec![NO_OPAQUE; texels],
    };
    for texel in 0..texels {
        if let Some(front) = ball.front(texel, side) {
            let chord = 2.0 * (ball.z - front);
            out.items.extend((0..=STEPS).map(|i| Fragment {
                depth: (front + chord * f64::from(i) / f64::from(STEPS)) as f32,
                omega: 0.1,
            }));
        }
        out.starts.push(out.items.len() as u32);
    }
    (out, ball)
}

/// Slope of a method's boundary at a share of its layers against the ball's front.
fn slope(method: &Method, fragments: &Fragments, ball: &Ball, share: f64) -> f64 {
    let Code::Layered(layered) = &method.settings.code else { return f64::NAN };
    let code = LayeredCode::new(layered, Opaque::Separate);
    let layers = layered.layers as usize;
    let (mut words, mut scratch) = (vec![0.0; code.words()], Vec::new());
    let mut pairs = Vec::new();
    for texel in 0..fragments.texels() {
        let Some(front) = ball.front(texel, fragments.width) else { continue };
        if fragments.texel(texel).len() < 2 {
            continue;
        }
        code.encode(texel, fragments.texel(texel), None, &mut scratch, &mut words);
        let bounds = code.placement.read(&words);
        // The boundary is where receivers step into the layer.
        let behind = |depth: f32| match code.placement.place(bounds, layers, depth) {
            Place::Before => false,
            Place::At(c) => f64::from(c) >= share * layers as f64,
            Place::Behind => true,
        };
        let (mut near, mut far) = (0.0_f32, 2.0_f32);
        for _ in 0..32 {
            let middle = 0.5 * (near + far);
            if behind(middle) { far = middle } else { near = middle }
        }
        pairs.push((front, f64::from(far)));
    }
    fitted(&pairs)
}

/// Slope of the least-squares line.
fn fitted(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let joint: f64 = pairs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
    joint / pairs.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}

fn slopes(fragments: &Fragments, ball: &Ball, resolution: u32) -> Slopes {
    let diameter = (2.0 * ball.radius_z) as f32;
    let all = |method: Method| {
        SHARES.map(|share| slope(&method.clone().at(resolution), fragments, ball, share))
    };
    Slopes { bounding: all(bom(LAYERS)), deep: all(dom(LAYERS, diameter)) }
}

fn surfaces(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (even, ball) = even_ball(64);
    let mut found = vec![("even ball", slopes(&even, &ball, 64))];
    if let Volume::Ball { centre, radius } = SPHERE_CLOUD.volume {
        let still = still("sphere_cloud")?;
        let method = bom(LAYERS);
        let view = still.case.view(true);
        let at = view.project(centre);
        let ball = Ball {
            u: at.x,
            v: at.y,
            z: at.z,
            radius_uv: radius / view.side_m(),
            radius_z: radius / (view.far_m - view.near_m),
        };
        let fragments = still.fragments(&method)?;
        found.push(("ball of squares", slopes(&fragments, &ball, method.resolution)));
    }
    let mut figures = Vec::new();
    for (name, slopes) in &found {
        for (i, share) in SHARES.iter().enumerate() {
            let what = format!("{name}, u = {share}: slope against the front");
            figures.push(figure(format!("{what}, bounding"), slopes.bounding[i], ""));
            figures.push(figure(format!("{what}, deep"), slopes.deep[i], ""));
        }
    }
    let all: Vec<Slopes> = found.iter().map(|f| f.1).collect();
    let verdict = all_of(&[follow(&all)]);
    let told: Vec<String> = found
        .iter()
        .map(|(name, s)| format!("{name} {:.2?}, deep {:.2?}", s.bounding, s.deep))
        .collect();
    let because =
        format!("slopes of boundaries against the front, 1 - 2u by both: {}", told.join("; "));
    Ok(judged(verdict, because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Refuted, Reproduced};

    #[test]
    fn ends_may_differ_by_a_last_place() {
        assert_eq!(same_ends(&[0.0, 2f64.powi(-24)]), Reproduced);
        assert_eq!(same_ends(&[0.0, 1e-6]), Refuted);
        assert_eq!(same_ends(&[]), Refuted);
    }

    #[test]
    fn boundaries_must_follow_both_and_deep_ones_the_front_alone() {
        let good = Slopes { bounding: [0.5, 0.0, -0.5], deep: [1.0; 3] };
        assert_eq!(follow(&[good]), Reproduced);
        assert_eq!(follow(&[good, Slopes { bounding: [0.5, 0.2, -0.5], ..good }]), Refuted);
        assert_eq!(follow(&[Slopes { deep: [1.0, 1.0, 0.5], ..good }]), Refuted);
        assert_eq!(follow(&[Slopes { bounding: [f64::NAN; 3], ..good }]), Refuted);
    }

    #[test]
    fn a_line_has_its_slope() {
        assert!((fitted(&[(0.0, 1.0), (1.0, -1.0), (2.0, -3.0)]) + 2.0).abs() < 1e-12);
    }
}
