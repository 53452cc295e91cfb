//! Fragments on light rays, and maps of them by definition.

use dapple_opacity_maps::{Fragment, Fragments, NO_OPAQUE};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

pub fn random(seed: u64) -> Pcg64Mcg {
    Pcg64Mcg::seed_from_u64(seed)
}

/// Fragments of each texel as the closure draws them.
pub fn fragments(
    width: u32,
    height: u32,
    seed: u64,
    draw: impl Fn(&mut Pcg64Mcg, u32, u32, &mut Vec<Fragment>),
) -> Fragments {
    let mut random = random(seed);
    let mut out = Fragments { width, height, starts: vec![0], ..Fragments::default() };
    for y in 0..height {
        for x in 0..width {
            draw(&mut random, x, y, &mut out.items);
            out.starts.push(out.items.len() as u32);
        }
    }
    out.opaque = vec![NO_OPAQUE; out.texels()];
    out.check().unwrap();
    out
}

/// A Poisson stream along a ray: `density` fragments per unit of depth from `near` to `far`.
pub fn poisson(
    random: &mut Pcg64Mcg,
    (near, far): (f32, f32),
    density: f32,
    omega: f32,
    out: &mut Vec<Fragment>,
) {
    let mut depth = near;
    loop {
        depth -= (1.0 - random.random::<f32>()).ln() / density;
        if depth >= far {
            break;
        }
        out.push(Fragment { depth, omega });
    }
}

/// Rays of one density whose volume begins and ends at random.
pub fn volume(side: u32, seed: u64, density: f32, omega: f32) -> Fragments {
    fragments(side, side, seed, |random, _, _, out| {
        let near = 0.1 + 0.2 * random.random::<f32>();
        let far = 0.7 + 0.2 * random.random::<f32>();
        poisson(random, (near, far), density, omega, out);
    })
}

/// H(t), normalised, of ratio 511.
pub fn split(lambda: f64, t: f64) -> f64 {
    (1.0 - lambda) * t + lambda * (1.0 + 510.0 * t).log2() / 511f64.log2()
}

/// Cumulative sums of K layers between each ray's ends, by definition.
pub fn sums(fragments: &Fragments, lambda: f64, layers: usize) -> Vec<f32> {
    let mut out = vec![0.0f32; fragments.texels() * layers];
    for (texel, sums) in out.chunks_mut(layers).enumerate() {
        let all = fragments.texel(texel);
        let near = all.iter().map(|f| f.depth).fold(f32::MAX, f32::min);
        let far = all.iter().map(|f| f.depth).fold(f32::MIN, f32::max);
        for f in all {
            let span = f64::from(far - near).max(1e-6);
            let u = split(lambda, f64::from(f.depth - near) / span);
            let layer = ((u * layers as f64) as usize).min(layers - 1);
            sums[layer..].iter_mut().for_each(|sum| *sum += f.omega);
        }
    }
    out
}
