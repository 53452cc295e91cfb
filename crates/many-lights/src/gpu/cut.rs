//! Cuts on a device: R3 and R4 by a walk a pixel, or one a tile; R2 by [`super::lightcuts`].
//!
//! Based on: Melino Conte, "Real-time Rendering of Cities at Night", 2018, sections 3.1 (skip counts),
//! 3.2 (rules) and 5.2.1 (precuts on a device).
//! Deviations: the cut of a tile is ours.

use super::{
    kernel::{Kernel, Parts},
    lightcuts::{LightcutsParams, Room},
    room::{put, with_room},
    scene::Scene,
    tree::{Sent, Tree},
};
use crate::{
    BoundForm, Light, LightTree, Lighting, LightsError, Shaded, Times,
    cut::{Given, Method, Rule, Starting, Starts},
    light::PackedLight,
};
use bytemuck::{Pod, Zeroable};
use dapple_gpu::wgpu;
use std::sync::Arc;

/// Mirrors `RuleParams` of `common/lights_rule.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct RuleParams {
    limit: f32,
    moving: [u32; 2],
    pad: u32,
}

/// The device's form of all techniques that make cuts.
struct OnDevice<'g> {
    scene: Arc<Scene<'g>>,
    given: Given,
    tree: Tree,
    /// R2's.
    room: Option<Room>,
    params: wgpu::Buffer,
    /// For shadow rays: the scene's lights and those that move, once any do.
    lights: Option<wgpu::Buffer>,
    kernel: Kernel<'g>,
}

/// Cuts as `given` says.
///
/// # Errors
/// A tree or a cut over a limit of the device, by name; lights other than the scene's.
pub fn cut<'g>(
    scene: &Arc<Scene<'g>>,
    given: &Given,
) -> Result<Box<dyn Starting + 'g>, LightsError> {
    let scene = super::scene_with_shadows(Some(scene), &given.world)?;
    let tree = Tree::new(scene.gpu, &given.tree.pack(), &given.starts)?;
    let room = room(scene, given)?;
    let params = scene.gpu.uniform("cut", &params(given, room.as_ref()))?;
    let kernel = kernel(scene, given, &tree, room.as_ref(), &params)?;
    let (scene, given) = (Arc::clone(scene), given.clone());
    Ok(Box::new(OnDevice { scene, given, tree, room, params, lights: None, kernel }))
}

fn room(scene: &Scene<'_>, given: &Given) -> Result<Option<Room>, LightsError> {
    match given.method {
        Method::Worst(settings) => Ok(Some(Room::new(scene, given.most_open(&settings))?)),
        Method::Rule(..) | Method::Tile { .. } => Ok(None),
    }
}

/// The kernel's uniform: [`LightcutsParams`], or [`RuleParams`] and nothing behind.
fn params(given: &Given, room: Option<&Room>) -> [u32; 8] {
    let moving = given.moving.range();
    let limit = match given.method {
        Method::Worst(settings) => {
            let params = LightcutsParams {
                epsilon: finite(settings.epsilon),
                most: settings.most,
                threads: room.map_or(0, Room::threads),
                moving,
                ..LightcutsParams::default()
            };
            return bytemuck::cast(params);
        }
        Method::Tile { threshold, .. } | Method::Rule(Rule::Absolute(threshold), _) => threshold,
        Method::Rule(Rule::Relative(epsilon), _) => epsilon,
    };
    let params = RuleParams { limit: finite(limit), moving, ..RuleParams::default() };
    let [first, second]: [[u32; 4]; 2] = [bytemuck::cast(params), [0; 4]];
    bytemuck::cast([first, second])
}

fn kernel<'g>(
    scene: &Arc<Scene<'g>>,
    given: &Given,
    tree: &Tree,
    room: Option<&Room>,
    params: &wgpu::Buffer,
) -> Result<Kernel<'g>, LightsError> {
    let (pass, path, form) = match given.method {
        Method::Worst(settings) => ("lightcuts", "many-lights/lightcuts.wgsl", settings.bound),
        Method::Tile { form, .. } => ("cut", "many-lights/cut_tile.wgsl", form),
        Method::Rule(_, form) => ("cut", "many-lights/cut.wgsl", form),
    };
    let is_relative = matches!(given.method, Method::Rule(Rule::Relative(_), _));
    let mut constants =
        vec![form_constant(form), ("HEIGHTS", f64::from(u8::from(tree.has_heights())))];
    if room.is_none() {
        constants.push(("RELATIVE", f64::from(u8::from(is_relative))));
    }
    Kernel::new(
        scene,
        &Parts {
            pass,
            path,
            constants: &constants,
            buffers: &buffers(tree, room, params),
            evaluates_all: is_relative || room.is_some(),
            most_groups: room.map(|room| room.groups),
        },
    )
}

/// Bindings of group 1.
fn buffers<'b>(
    tree: &'b Tree,
    room: Option<&'b Room>,
    params: &'b wgpu::Buffer,
) -> Vec<&'b wgpu::Buffer> {
    let mut buffers = vec![&tree.nodes, &tree.starts, &tree.ranges, params];
    buffers.extend(room.map(|room| &room.open));
    buffers
}

impl OnDevice<'_> {
    /// Makes R2's room larger where the starts want more; whether it did.
    fn make_room(&mut self) -> Result<bool, LightsError> {
        let (Method::Worst(settings), Some(room)) = (self.given.method, &self.room) else {
            return Ok(false);
        };
        let rows = self.given.most_open(&settings);
        let grows = rows > room.rows;
        if grows {
            self.room = Some(Room::new(&self.scene, rows)?);
        }
        Ok(grows)
    }

    /// What a change left: the uniform, and bindings or the whole kernel.
    fn renew(&mut self, is_other: bool, is_rebound: bool) -> Result<(), LightsError> {
        let params = params(&self.given, self.room.as_ref());
        self.scene.gpu.queue.write_buffer(&self.params, 0, bytemuck::bytes_of(&params));
        let room = self.room.as_ref();
        if is_other {
            self.kernel = kernel(&self.scene, &self.given, &self.tree, room, &self.params)?;
        } else if is_rebound {
            self.kernel.bind(&buffers(&self.tree, room, &self.params));
        }
        if let Some(lights) = self.lights.as_ref().filter(|_| is_other || is_rebound) {
            self.kernel.bind_shadow_lights(lights);
        }
        Ok(())
    }

    /// Uploads lights that move, for shadow rays.
    fn put_lights(&mut self) -> Result<Sent, LightsError> {
        let moving: Vec<PackedLight> = self.given.moving.lights().iter().map(Light::pack).collect();
        if !self.scene.occluders().are_there() || (moving.is_empty() && self.lights.is_none()) {
            return Ok(Sent::default());
        }
        let at = (self.scene.world.lights.len() * size_of::<PackedLight>()) as u64;
        let (gpu, data) = (self.scene.gpu, bytemuck::cast_slice(&moving));
        let bytes = data.len() as u64;
        // The scene's own are those of every technique: nothing is written there.
        let is_first = self.lights.is_none();
        let mut lights = match self.lights.take() {
            Some(lights) => lights,
            None => with_room(gpu, "all lights", self.scene.lights(), at, bytes)?,
        };
        let is_rebound = put(gpu, "all lights", &mut lights, at, data)? || is_first;
        self.lights = Some(lights);
        Ok(Sent { bytes, is_rebound })
    }
}

impl Starting for OnDevice<'_> {
    fn start(&mut self, starts: &Starts) -> Result<u64, LightsError> {
        self.given.set_starts(starts)?;
        let had_heights = self.tree.has_heights();
        let sent = self.tree.start(self.scene.gpu, starts)?;
        let grows = self.make_room()?;
        self.renew(grows || self.tree.has_heights() != had_heights, sent.is_rebound)?;
        Ok(sent.bytes)
    }

    fn replace_moving(&mut self, lights: &[Light], tree: &LightTree) -> Result<u64, LightsError> {
        self.given.set_moving(lights, tree)?;
        let sent = self.tree.replace_moving(self.scene.gpu, &self.given.moving, &tree.pack())?;
        let lights = self.put_lights()?;
        let grows = self.make_room()?;
        self.renew(grows, sent.is_rebound || lights.is_rebound)?;
        Ok(sent.bytes + lights.bytes)
    }

    fn starts(&self) -> Result<Starts, LightsError> {
        self.tree.starts(self.scene.gpu)
    }
}

impl Lighting for OnDevice<'_> {
    fn reset(&mut self, seed: u32) -> Result<(), LightsError> {
        self.kernel.reset(seed)
    }

    fn shade(&mut self, index: usize, count: bool) -> Result<Times, LightsError> {
        self.kernel.shade(index, count)
    }

    fn read(&mut self, shaded: &mut Shaded) -> Result<(), LightsError> {
        self.kernel.read(shaded)
    }

    fn bytes(&self) -> u64 {
        self.kernel.bytes() + self.lights.as_ref().map_or(0, wgpu::Buffer::size)
    }
}

/// The constant `FORM` of `common/lights_tree.wgsl`.
fn form_constant(form: BoundForm) -> (&'static str, f64) {
    ("FORM", if form == BoundForm::Walter { 0.0 } else { 1.0 })
}

/// In f32, and the greatest number in place of an infinite one, which shaders need not know.
fn finite(limit: f64) -> f32 {
    (limit as f32).min(f32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_has_the_layout_of_the_shaders() {
        for path in ["many-lights/cut.wgsl", "many-lights/cut_tile.wgsl"] {
            let fields = [("limit", 0), ("moving", 4), ("moving_end", 8), ("pad", 12)];
            crate::gpu::mirror::<RuleParams>(path, "RuleParams", &fields);
        }
    }
}
