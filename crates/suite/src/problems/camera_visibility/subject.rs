//! A technique that draws along the path and is judged frame by frame.

use super::{SPEC, case::VisibilityCase, drawer::Drawer, errors::Score, method::Method, port};
use crate::{
    SuiteError,
    problem::{Checked, FrameTime, Picture, Setting, Subject},
};
use dapple_occlusion::camera::{Frame, Image, Work};
use std::time::Instant;

/// The technique that `setting` asks for.
///
/// # Errors
/// Settings that are refused, or a device that is too small.
pub fn of<'a>(
    case: &'a VisibilityCase<'_>,
    setting: &Setting,
) -> Result<Box<dyn Subject + 'a>, SuiteError> {
    Ok(Box::new(PathSubject::new(case, setting)?))
}

/// A technique with what it draws with and what it remembers.
pub struct PathSubject<'a, 'g> {
    case: &'a VisibilityCase<'g>,
    setting: Setting,
    drawer: Drawer<'g>,
    method: Method,
    out: Frame,
    drawn: bool,
}

impl<'a, 'g> PathSubject<'a, 'g> {
    /// Allocates what a frame needs; builds the hierarchy if no other setting has.
    ///
    /// # Errors
    /// As [`of`].
    pub fn new(case: &'a VisibilityCase<'g>, setting: &Setting) -> Result<Self, SuiteError> {
        SPEC.check(setting)?;
        Ok(Self {
            case,
            method: Method::of(case, setting)?,
            drawer: Drawer::of(case, setting)?,
            setting: setting.clone(),
            out: Frame::default(),
            drawn: false,
        })
    }

    /// Runs one frame and finds out what it drew.
    ///
    /// # Errors
    /// The renderer's.
    pub fn run(&mut self, index: usize) -> Result<(), SuiteError> {
        self.draw(index)?;
        self.method.collect(&self.drawer, &mut self.out)
    }

    fn draw(&mut self, index: usize) -> Result<(), SuiteError> {
        self.drawn = true;
        self.method.frame(self.case, index, &mut self.drawer, &mut self.out)
    }

    /// What the last frame drew.
    pub fn out(&self) -> &Frame {
        &self.out
    }

    /// What the last frame shows.
    ///
    /// # Errors
    /// The device's.
    pub fn image(&self) -> Result<Image, SuiteError> {
        self.drawer.image()
    }
}

impl Subject for PathSubject<'_, '_> {
    fn frames(&self) -> usize {
        self.case.views().len()
    }

    fn reset(&mut self) -> Result<(), SuiteError> {
        self.method.reset(&mut self.drawer)
    }

    fn frame(&mut self, index: usize) -> Result<FrameTime, SuiteError> {
        let start = Instant::now();
        self.draw(index)?;
        let passes = self.drawer.finish()?;
        // Host and device share a frame: the wall's clock alone sees both.
        Ok(FrameTime { wall_ns: start.elapsed().as_nanos() as u64, gpu_ns: None, passes })
    }

    fn check(&mut self) -> Result<Checked, SuiteError> {
        self.reset()?;
        let full = self.case.everything(self.setting.form)?;
        let mut checked = Checked::default();
        let (mut score, mut work, mut calls) = (Score::default(), Work::default(), 0);
        let mut covered = (0_u64, 0_u64);
        for index in 0..self.frames() {
            self.run(index)?;
            let image = self.image()?;
            let differences = port::differences(&image, &full[index]);
            if differences.nearer > 0 {
                checked.violations.push(format!(
                    "frame {index}: {} pixels lie nearer than when everything is drawn",
                    differences.nearer
                ));
            }
            if let Some(twice) = port::twice(&self.out.drawn) {
                checked.violations.push(format!("frame {index}: object {twice} is drawn twice"));
            }
            score.add(self.case, index, &self.out.drawn, differences.deeper);
            work += self.out.work;
            calls += self.drawer.draw_calls().unwrap_or(0);
            if let Some((stored, owned)) = self.method.coverage(self.case, &image) {
                covered = (covered.0 + stored, covered.1 + owned);
            }
        }
        checked.errors = score.errors();
        let told = if self.method.is_told() { 1.0 } else { 0.0 };
        checked.errors.insert("foreknowledge".into(), told);
        if covered.1 > 0 {
            let excess = covered.0 as f64 / covered.1 as f64 - 1.0;
            checked.errors.insert("coverage_excess".into(), excess);
        }
        if self.method.is_exact() && score.wrong_pixels() > 0 {
            checked.violations.push(format!(
                "{} pixels lie deeper than when everything is drawn: something that shows was \
                 culled",
                score.wrong_pixels()
            ));
        }
        let missed = checked.errors.get("missed").copied().unwrap_or(0.0);
        if self.method.is_exact() && missed > 0.0 {
            checked.violations.push(format!(
                "{missed:.1e} of the pixels are owned by objects that were not drawn"
            ));
        }
        port::hold(self.case, &self.setting, &full, &mut checked)?;
        checked.counters = port::counters(&work, self.frames());
        if calls > 0 {
            checked.counters.insert("draw_calls".into(), calls);
        }
        if let Some(cells) = self.method.cells(self.case, &self.out.drawn)? {
            checked.counters.insert("view_cells".into(), cells);
        }
        checked.memory_bytes = self.method.bytes() + self.drawer.bytes(self.case);
        Ok(checked)
    }

    fn picture(&mut self) -> Result<Option<Picture>, SuiteError> {
        if !self.drawn {
            self.reset()?;
            for index in 0..self.frames() {
                self.run(index)?;
            }
        }
        Ok(Some(self.case.picture(&self.image()?)))
    }
}
