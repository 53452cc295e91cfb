//! Techniques along the paths of random worlds, frame by frame.

use super::input;
use crate::{
    SuiteError,
    problem::{Form, Setting, Technique},
    problems::camera_visibility::{SPEC, case::VisibilityCase, drawer::Drawer, method::Method},
    verify::GateContext,
};
use dapple_gpu::Gpu;
use dapple_occlusion::camera::{Frame, Image, View};

/// Cases of a control: it has to be caught at once.
pub const CONTROLS: u32 = 4;

/// One frame as it was drawn.
pub struct Shown<'a, 'g> {
    /// The world.
    pub case: &'a VisibilityCase<'g>,
    /// What drew.
    pub setting: &'a Setting,
    /// Whether nothing that shows may be missing.
    pub exact: bool,
    /// Number of the frame.
    pub index: usize,
    /// Objects drawn, in order.
    pub drawn: &'a [u32],
    /// What it shows.
    pub image: &'a Image,
}

impl Shown<'_, '_> {
    /// What the frame is, in words.
    pub fn name(&self) -> String {
        let Self { case, setting, index, .. } = self;
        let seed = case.seed();
        format!("seed {seed}, {}, frame {index}, {setting} {:?}", case.scene(), setting.knobs)
    }

    /// The frame's view.
    pub fn view(&self) -> &View {
        &self.case.views()[self.index]
    }
}

/// Number of cases: at most `most`, a control's fewer.
pub fn cases(context: &GateContext<'_>, most: u32, faulty: bool) -> u32 {
    context.cases.min(if faulty { CONTROLS.min(most) } else { most })
}

/// Draws random settings of a technique along the paths of so many worlds, in each of the forms;
/// those of every other world are exact.
///
/// # Errors
/// The renderer's, or those of `look`.
pub fn along<'g>(
    technique: &Technique,
    forms: &[Form],
    context: &GateContext<'_>,
    cases: u32,
    gpu: Option<&'g Gpu>,
    mut look: impl FnMut(&Shown<'_, 'g>) -> Result<(), SuiteError>,
) -> Result<(), SuiteError> {
    for number in 0..cases {
        let case = input::case(context.seed, number, gpu)?;
        let mut rng = input::rng(context.seed, technique.id, number);
        for form in forms {
            let setting = input::setting(&mut rng, technique, *form, &case, number % 2 == 0);
            let mut method = Method::of(&case, &setting)?;
            let mut drawer = Drawer::of(&case, &setting)?;
            let mut out = Frame::default();
            for index in 0..case.views().len() {
                method.frame(&case, index, &mut drawer, &mut out)?;
                method.collect(&drawer, &mut out)?;
                let (exact, image) = (method.is_exact(), drawer.image()?);
                let (case, setting, drawn) = (&case, &setting, &out.drawn[..]);
                look(&Shown { case, setting, exact, index, drawn, image: &image })?;
            }
        }
    }
    Ok(())
}

/// What a form shows of a list of objects.
///
/// # Errors
/// The renderer's.
pub fn draw(shown: &Shown<'_, '_>, objects: &[u32]) -> Result<Image, SuiteError> {
    let plain = input::default_setting(&SPEC.techniques[0], shown.setting.form, &[])?;
    let mut drawer = Drawer::of(shown.case, &plain)?;
    let renderer = drawer.renderer()?;
    renderer.begin(shown.view())?;
    renderer.draw(objects)?;
    renderer.end()?;
    drawer.image()
}
