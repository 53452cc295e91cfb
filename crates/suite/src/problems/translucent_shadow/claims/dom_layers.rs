//! H4.5 and H4.6: what deep opacity maps store.

use super::{
    dom::listing,
    support::{Method, Still, dom, still},
    verdict::{figure, judged},
};
use crate::{
    SuiteError,
    claims::{Claim, ClaimContext, Judged, Verdict},
};
use dapple_opacity_maps::{Fragments, Lookup, cpu::Maps};

pub fn claims() -> Vec<Claim> {
    vec![
        Claim {
            id: "voicu-H4.5",
            statement: "Deep opacity maps light the front surface exactly: nothing shadows it",
            place: "Voicu 2011, section 4",
            method: "16 maps; every texel of grass, tree and hair that holds a fragment is read at \
                     its first fragment's depth; T must be 1 to 1e-6. Interpolated as in Yuksel and \
                     Keyser 2008: reproduced if it is. The sum of the own layer, which the thesis \
                     describes (one map read), is shown as the literal form",
            judge: Box::new(front),
        },
        Claim {
            id: "voicu-H4.6",
            statement: "Adding each fragment to all later maps stores the sums of all layers before, \
                        so that one read is enough",
            place: "Voicu 2011, section 4.2; appendix 5",
            method: "16 maps on grass, tree and hair against sums worked out apart in 64 bits: \
                     fragments sorted into slabs by (d - z0) / D K, then added up. Reproduced if no \
                     map differs by more than each fragment rounding once, relative to its sum. The \
                     printed masks are held to the same and shown",
            judge: Box::new(sums),
        },
    ]
}

/// Scenes of three kinds.
pub const THREE: [&str; 3] = ["grass", "tree", "hair"];

/// Greatest distance from full light on the front surface.
fn lit(worst: f64) -> Verdict {
    if worst <= 1e-6 { Verdict::Reproduced } else { Verdict::Refuted }
}

/// Greatest and mean lack of light at every texel's first fragment.
fn lack(still: &Still, method: &Method) -> Result<(f64, f64), SuiteError> {
    let (maps, exact) = (still.maps(method)?, still.exact(method)?);
    let at = |texel: usize| {
        let (first, _) = exact.ends(texel)?;
        Some(1.0 - f64::from(maps.code().decode(texel, maps.texel(texel), first)))
    };
    let lacks: Vec<f64> = (0..maps.texels()).filter_map(at).collect();
    let mean = lacks.iter().sum::<f64>() / lacks.len().max(1) as f64;
    Ok((lacks.iter().map(|l| l.abs()).fold(0.0, f64::max), mean))
}

fn front(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut worst, mut literal) = (Vec::new(), 0.0_f64, 0.0_f64);
    for scene in THREE {
        let still = still(scene)?;
        let method = dom(16, still.deepest()?);
        for (name, lookup) in [("interpolated", Lookup::Lerp), ("own layer's sum", Lookup::Nearest)]
        {
            let (most, mean) = lack(&still, &method.clone().lookup(lookup))?;
            figures.push(figure(format!("{scene}, {name}: greatest lack of light"), most, ""));
            figures.push(figure(format!("{scene}, {name}: mean lack of light"), mean, ""));
            if lookup == Lookup::Lerp {
                worst = worst.max(most);
            } else {
                literal = literal.max(mean);
            }
        }
    }
    let because = format!(
        "interpolated, no first fragment lacks more than {worst:.1e} of its light; read as the own \
         layer's sum it lacks up to {literal:.2} of it in the mean of a scene"
    );
    Ok(judged(lit(worst), because, figures))
}

/// Greatest difference of a map from the sum worked out apart, in roundings of that sum; share of
/// maps that differ by more than all their fragments' roundings.
#[derive(Clone, Copy, Debug)]
struct Off {
    roundings: f64,
    share: f64,
}

fn prefix(repaired: &[Off]) -> Verdict {
    let exact = repaired.iter().all(|off| off.share == 0.0);
    if exact && !repaired.is_empty() { Verdict::Reproduced } else { Verdict::Refuted }
}

/// Built maps against slabs summed up in 64 bits.
fn off(maps: &Maps, fragments: &Fragments, layers: usize, span: f32) -> Off {
    let mut off = Off { roundings: 0.0, share: 0.0 };
    let (mut wrong, mut all) = (0_u64, 0_u64);
    for texel in 0..fragments.texels() {
        let items = fragments.texel(texel);
        let first = items.iter().map(|f| f.depth).fold(f32::INFINITY, f32::min);
        let mut slabs = vec![0.0_f64; layers];
        for f in items {
            // In the precision of the maps, so that ties fall the same way.
            let k = ((f.depth - first) / span * layers as f32) as usize;
            slabs[k.min(layers - 1)] += f64::from(f.omega);
        }
        let words = maps.texel(texel);
        let mut sum = 0.0;
        for (stored, slab) in words[words.len() - layers..].iter().zip(slabs) {
            sum += slab;
            let step = f64::from(f32::EPSILON) * sum.max(f64::from(f32::MIN_POSITIVE));
            let roundings = (f64::from(*stored) - sum).abs() / step;
            off.roundings = off.roundings.max(roundings);
            wrong += u64::from(roundings > items.len() as f64);
            all += u64::from(!items.is_empty());
        }
    }
    off.share = wrong as f64 / all.max(1) as f64;
    off
}

fn sums(_: &ClaimContext<'_>) -> Result<Judged, SuiteError> {
    let (mut figures, mut repaired, mut printed) = (Vec::new(), Vec::new(), 0.0_f64);
    for scene in THREE {
        let still = still(scene)?;
        let span = still.deepest()?;
        let method = dom(16, span);
        let fragments = still.fragments(&method)?;
        for (name, method) in [("repaired", method.clone()), ("as printed", listing(method))] {
            let off = off(&still.maps(&method)?, &fragments, 16, span);
            figures.push(figure(format!("{scene}, {name}: share of maps off"), off.share, ""));
            figures.push(figure(format!("{scene}, {name}: error"), still.layering(&method)?, ""));
            if name == "repaired" {
                let what = format!("{scene}: greatest difference of a map");
                figures.push(figure(what, off.roundings, "roundings of its sum"));
                repaired.push(off);
            } else {
                printed = printed.max(off.share);
            }
        }
    }
    let because = format!(
        "added to all maps from its layer's on, every map is the sum to rounding; by the printed \
         masks up to {:.0} % of the maps are not",
        100.0 * printed
    );
    Ok(judged(prefix(&repaired), because, figures))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Verdict::{Refuted, Reproduced};

    #[test]
    fn a_front_that_lacks_light_refutes() {
        assert_eq!(lit(0.0), Reproduced);
        assert_eq!(lit(0.01), Refuted);
        assert_eq!(lit(f64::NAN), Refuted);
    }

    #[test]
    fn one_map_that_is_off_refutes() {
        let of = |share| Off { roundings: 1.0, share };
        assert_eq!(prefix(&[of(0.0), of(0.0)]), Reproduced);
        assert_eq!(prefix(&[of(0.0), of(0.01)]), Refuted);
        assert_eq!(prefix(&[]), Refuted);
    }
}
