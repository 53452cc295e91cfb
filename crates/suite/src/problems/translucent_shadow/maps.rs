//! What the light meets, by crop, resolution and thickness model: made once, shared by settings.

use super::case::TranslucentCase;
use crate::SuiteError;
use dapple_opacity_maps::{
    Fragments, Model,
    exact::{self, Exact},
};
use dapple_trace::LightFragments;
use std::{cell::RefCell, collections::BTreeMap, rc::Rc};

/// Crop and resolution.
type Grid = (bool, u32);

/// Most bytes of surfaces kept for one case.
const MOST_BYTES: usize = 3 << 30;

/// Caches of one case.
#[derive(Default)]
pub struct Maps {
    surfaces: RefCell<BTreeMap<Grid, Rc<LightFragments>>>,
    fragments: RefCell<BTreeMap<(Grid, bool), Rc<Fragments>>>,
    exact: RefCell<BTreeMap<(Grid, bool), Rc<Exact>>>,
}

impl Maps {
    /// Every surface through the texels' centres.
    pub fn surfaces(
        &self,
        case: &TranslucentCase<'_>,
        crop: bool,
        resolution: u32,
    ) -> Result<Rc<LightFragments>, SuiteError> {
        once(&self.surfaces, (crop, resolution), || {
            let found = case.light_fragments(crop, resolution)?;
            let bytes = 8 * found.depth.len();
            if bytes > MOST_BYTES {
                return Err(SuiteError::Value {
                    what: "knob",
                    name: "resolution".into(),
                    value: resolution.to_string(),
                    limit: format!(
                        "{} fragments take {bytes} bytes; {MOST_BYTES} bytes are allowed",
                        found.depth.len()
                    ),
                });
            }
            Ok(found)
        })
    }

    /// The same as techniques take them.
    pub fn fragments(
        &self,
        case: &TranslucentCase<'_>,
        crop: bool,
        resolution: u32,
        model: Model,
    ) -> Result<Rc<Fragments>, SuiteError> {
        once(&self.fragments, ((crop, resolution), model == Model::ExpTau), || {
            let found = self.surfaces(case, crop, resolution)?;
            let opacities = case.caster_opacities();
            let (side, starts) = (resolution, &found.starts);
            Ok(exact::collect(side, side, starts, model, |i| {
                let triangle = found.triangle[i];
                (found.depth[i], opacities.alpha(triangle), opacities.is_opaque(triangle))
            }))
        })
    }

    /// The uncompressed deep shadow map of them.
    pub fn exact(
        &self,
        case: &TranslucentCase<'_>,
        crop: bool,
        resolution: u32,
        model: Model,
    ) -> Result<Rc<Exact>, SuiteError> {
        once(&self.exact, ((crop, resolution), model == Model::ExpTau), || {
            Ok(Exact::of(&*self.fragments(case, crop, resolution, model)?))
        })
    }
}

/// The value under `key`, made if it is not there.
fn once<K: Ord + Copy, V>(
    map: &RefCell<BTreeMap<K, Rc<V>>>,
    key: K,
    make: impl FnOnce() -> Result<V, SuiteError>,
) -> Result<Rc<V>, SuiteError> {
    if let Some(value) = map.borrow().get(&key) {
        return Ok(Rc::clone(value));
    }
    let value = Rc::new(make()?);
    map.borrow_mut().insert(key, Rc::clone(&value));
    Ok(value)
}
