//! What each technique means, in `f64`, straight from the fragments: the oracle of ports.
//!
//! Nothing is stored and nothing is fast: a transmittance is worked out from its definition over
//! the texel's fragments each time it is asked for.

use crate::{
    Blur, Code, Fragment, Fragments, OpacityError, Opaque, Receiver, Settings, adaptive, binary,
    cpu, deep, fourier, layered,
    layered::reference::LayeredReference,
    moments, stochastic,
    taps::{self, MOST, Tap},
};

/// A technique over fragments at hand.
pub struct Reference<'a> {
    settings: &'a Settings,
    fragments: &'a Fragments,
    layered: Option<LayeredReference<'a>>,
}

impl<'a> Reference<'a> {
    /// Looks at all fragments where the technique needs it (planes of an OSM).
    ///
    /// # Errors
    /// Settings or fragments that are out of range.
    pub fn new(settings: &'a Settings, fragments: &'a Fragments) -> Result<Self, OpacityError> {
        settings.check()?;
        fragments.check()?;
        let layered = match &settings.code {
            Code::Layered(l) => Some(LayeredReference::new(l, settings.opaque, fragments)),
            _ => None,
        };
        Ok(Self { settings, fragments, layered })
    }

    /// Transmittance of one receiver; 1 outside the map.
    pub fn transmittance(&self, receiver: &Receiver) -> f64 {
        let at = |texel, depth| self.at(texel, depth);
        self.filtered(receiver, &at, &|own, taps, depth| self.stored(own, taps, depth))
    }

    /// Least and greatest transmittance of one receiver where rounding decides in which layer
    /// something lies; twice the same for codes without layers.
    pub fn interval(&self, receiver: &Receiver) -> (f64, f64) {
        let Some(layered) = &self.layered else {
            let t = self.transmittance(receiver);
            return (t, t);
        };
        let least = self.filtered(
            receiver,
            &|texel, depth| layered.interval(texel, depth).0,
            &|own, taps, depth| layered.stored_interval(own, taps, depth).0,
        );
        let greatest = self.filtered(
            receiver,
            &|texel, depth| layered.interval(texel, depth).1,
            &|own, taps, depth| layered.stored_interval(own, taps, depth).1,
        );
        (least, greatest)
    }

    /// Filters what single texels, or the mean of several, answer.
    fn filtered(
        &self,
        receiver: &Receiver,
        at: &dyn Fn(usize, f32) -> f64,
        stored: &dyn Fn(usize, &[Tap], f32) -> f64,
    ) -> f64 {
        if !receiver.in_map() {
            return 1.0;
        }
        let mut found = [Tap { texel: 0, du: 0.0, dv: 0.0 }; MOST];
        let (width, height) = (self.fragments.width, self.fragments.height);
        let n = taps::taps(self.settings.taps, receiver, width, height, &mut found);
        let found = &found[..n];
        let bias = self.settings.bias;
        let lit = |tap: &Tap| {
            self.settings.opaque != Opaque::Separate
                || cpu::is_lit(receiver, tap, bias, self.fragments.opaque[tap.texel])
        };
        let depth = receiver.depth - bias;
        let mean = |of: &dyn Fn(&Tap) -> f64| found.iter().map(of).sum::<f64>() / n as f64;
        match self.settings.blur {
            Blur::Transmittance => mean(&|tap| if lit(tap) { at(tap.texel, depth) } else { 0.0 }),
            Blur::Stored => {
                let own = taps::own(receiver, width, height);
                mean(&|tap| f64::from(u8::from(lit(tap)))) * stored(own, found, depth)
            }
        }
    }

    /// Transmittance of a texel just before `depth`.
    pub fn at(&self, texel: usize, depth: f32) -> f64 {
        let (fragments, opaque) = self.texel(texel);
        let stretched = self.settings.opaque_in_bounds();
        match &self.settings.code {
            Code::Unshadowed => 1.0,
            Code::Layered(_) => self.layered.as_ref().map_or(1.0, |l| l.at(texel, depth)),
            Code::Binary => binary::reference(fragments, opaque, depth),
            Code::Fourier(f) => fourier::reference(f, fragments, opaque, stretched, depth),
            Code::Adaptive(a) => adaptive::reference(a, fragments, opaque, depth),
            Code::Moments(m) => moments::reference(m, fragments, opaque, stretched, depth),
            Code::Stochastic(s) => stochastic::reference(s, texel, fragments, opaque, depth),
            Code::Deep(d) => deep::reference(d, fragments, opaque, depth),
        }
    }

    /// Fragments that go into the opacity maps.
    fn texel(&self, texel: usize) -> (&[Fragment], Option<Fragment>) {
        let opaque = cpu::weighted(self.settings.opaque, self.fragments.opaque[texel]);
        (self.fragments.texel(texel), opaque)
    }

    /// Transmittance of texels whose stored numbers are averaged first; a receiver's `own` texel
    /// says where layers lie.
    fn stored(&self, own: usize, taps: &[Tap], depth: f32) -> f64 {
        let texels = || taps.iter().map(|tap| self.texel(tap.texel));
        match &self.settings.code {
            Code::Layered(_) => self.layered.as_ref().map_or(1.0, |l| l.stored(own, taps, depth)),
            Code::Fourier(f) if !f.bounded => fourier::reference_mean(f, texels(), depth),
            Code::Moments(m) if !m.bounded => moments::reference_mean(m, texels(), depth),
            _ => {
                let sum: f64 = taps.iter().map(|tap| self.at(tap.texel, depth)).sum();
                sum / taps.len().max(1) as f64
            }
        }
    }
}

/// Whether rounding decides a receiver's transmittance: a fragment of one of its texels, or the
/// receiver, lies so near to a layer boundary that the answers on both sides differ by more than
/// [`layered::reference::TIE`]. Codes without layers have no such ties.
///
/// # Errors
/// As [`Reference::new`], which those who ask for many receivers use with [`Reference::interval`].
pub fn near_tie(
    settings: &Settings,
    fragments: &Fragments,
    receiver: &Receiver,
) -> Result<bool, OpacityError> {
    let (least, greatest) = Reference::new(settings, fragments)?.interval(receiver);
    Ok(greatest - least > layered::reference::TIE)
}

/// The exact answer on the same texel grid: e^-Σω over fragments strictly in front of `depth`.
pub fn exact(fragments: &[Fragment], depth: f32) -> f64 {
    let in_front = fragments.iter().filter(|f| f.depth < depth);
    (-in_front.map(|f| f64::from(f.omega)).sum::<f64>()).exp()
}
