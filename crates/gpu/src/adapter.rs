//! Which adapters there are, and which one to take.

use std::sync::OnceLock;

use serde::Serialize;

use crate::GpuError;

/// How to get an adapter on a machine without one.
const HINT: &str =
    "on Debian, `.ci/lavapipe` installs a software one (Mesa lavapipe); cpu forms run without";

/// Which adapter to open.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum AdapterChoice {
    /// The first of [`adapters`]: hardware before software. Never the GL backend, which is kept
    /// for those who name it.
    #[default]
    Auto,
    /// The first whose name, driver or backend contains this text, whatever its case.
    Named(String),
}

/// Whether an adapter is a graphics card or a program that imitates one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum AdapterKind {
    /// A graphics processor.
    Hardware,
    /// Computed on the CPU: times are never ranked against hardware.
    Software,
}

/// What an adapter says of itself.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct AdapterFacts {
    /// Name of the device.
    pub name: String,
    /// `vulkan`, `metal`, `dx12` or `gl`.
    pub backend: String,
    /// Name of the driver.
    pub driver: String,
    /// Version of the driver.
    pub driver_info: String,
    /// Hardware or software.
    pub kind: AdapterKind,
}

impl AdapterFacts {
    fn of(info: &wgpu::AdapterInfo) -> Self {
        AdapterFacts {
            name: info.name.clone(),
            backend: format!("{:?}", info.backend).to_lowercase(),
            driver: info.driver.clone(),
            driver_info: info.driver_info.clone(),
            kind: kind(info),
        }
    }

    /// One line for lists and errors.
    pub fn line(&self) -> String {
        let kind = if self.kind == AdapterKind::Software { ", software" } else { "" };
        format!("{} ({}, {} {}{kind})", self.name, self.backend, self.driver, self.driver_info)
    }
}

/// Every adapter of this machine: hardware first, and Vulkan, Metal, DX12 before GL.
pub fn adapters() -> Vec<AdapterFacts> {
    enumerate().iter().map(|adapter| AdapterFacts::of(&adapter.get_info())).collect()
}

/// The adapter that `choice` asks for.
pub(crate) fn choose(choice: &AdapterChoice) -> Result<(wgpu::Adapter, AdapterFacts), GpuError> {
    let all = enumerate();
    let facts: Vec<_> = all.iter().map(|a| AdapterFacts::of(&a.get_info())).collect();
    let index = pick(&facts, choice)?;
    match (all.into_iter().nth(index), facts.into_iter().nth(index)) {
        (Some(adapter), Some(facts)) => Ok((adapter, facts)),
        _ => Err(GpuError::NoAdapter { hint: HINT.into() }),
    }
}

/// Index of the adapter that `choice` asks for in a list sorted as [`adapters`].
fn pick(facts: &[AdapterFacts], choice: &AdapterChoice) -> Result<usize, GpuError> {
    let none = || GpuError::NoAdapter { hint: HINT.into() };
    match choice {
        AdapterChoice::Auto => facts.iter().position(|f| f.backend != "gl").ok_or_else(none),
        AdapterChoice::Named(_) if facts.is_empty() => Err(none()),
        AdapterChoice::Named(asked) => {
            let wanted = asked.to_lowercase();
            let matches = |f: &AdapterFacts| {
                [&f.name, &f.backend, &f.driver].iter().any(|s| s.to_lowercase().contains(&wanted))
            };
            facts.iter().position(matches).ok_or_else(|| GpuError::NotFound {
                asked: asked.clone(),
                have: facts.iter().map(AdapterFacts::line).collect::<Vec<_>>().join("; "),
            })
        }
    }
}

fn enumerate() -> Vec<wgpu::Adapter> {
    let mut all = pollster::block_on(instance().enumerate_adapters(wgpu::Backends::all()));
    all.sort_by_key(|adapter| rank(&adapter.get_info()));
    all
}

/// Sort key: hardware, then discrete, integrated, virtual, then backend.
fn rank(info: &wgpu::AdapterInfo) -> (AdapterKind, u8, u8) {
    let device = match info.device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    };
    let backend = match info.backend {
        wgpu::Backend::Vulkan | wgpu::Backend::Metal => 0,
        wgpu::Backend::Dx12 => 1,
        _ => 2,
    };
    (kind(info), u8::from(backend == 2), device * 4 + backend)
}

/// Names that software adapters go by; some report another device type than `Cpu`.
const SOFTWARE_NAMES: [&str; 6] =
    ["llvmpipe", "lavapipe", "softpipe", "swiftshader", "warp", "basic render"];

fn kind(info: &wgpu::AdapterInfo) -> AdapterKind {
    let text = format!("{} {} {}", info.name, info.driver, info.driver_info).to_lowercase();
    let named = text
        .split(|c: char| !c.is_alphanumeric() && c != ' ')
        .any(|part| SOFTWARE_NAMES.iter().any(|name| part.contains(name)));
    if named || info.device_type == wgpu::DeviceType::Cpu {
        AdapterKind::Software
    } else {
        AdapterKind::Hardware
    }
}

pub(crate) fn instance() -> &'static wgpu::Instance {
    static INSTANCE: OnceLock<wgpu::Instance> = OnceLock::new();
    INSTANCE.get_or_init(|| {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::VULKAN
            | wgpu::Backends::METAL
            | wgpu::Backends::DX12
            | wgpu::Backends::GL;
        // No driver-side debug layers: they cost time, and old ones reject what naga writes.
        descriptor.flags = wgpu::InstanceFlags::empty();
        wgpu::Instance::new(descriptor)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn facts(name: &str, backend: &str) -> AdapterFacts {
        AdapterFacts {
            name: name.into(),
            backend: backend.into(),
            driver: "some driver".into(),
            driver_info: "1.2".into(),
            kind: AdapterKind::Hardware,
        }
    }

    #[test]
    fn auto_takes_the_first_that_is_not_gl() {
        let list = [facts("a", "gl"), facts("b", "vulkan"), facts("c", "vulkan")];
        assert_eq!(pick(&list, &AdapterChoice::Auto), Ok(1));
        let only_gl = pick(&list[..1], &AdapterChoice::Auto).unwrap_err();
        assert!(only_gl.to_string().contains(".ci/lavapipe"), "{only_gl}");
    }

    #[test]
    fn a_name_matches_name_driver_or_backend_in_any_case() {
        let list = [facts("NVIDIA H200", "vulkan"), facts("llvmpipe", "vulkan"), facts("x", "gl")];
        let named = |text: &str| pick(&list, &AdapterChoice::Named(text.into()));
        assert_eq!(named("h200"), Ok(0));
        assert_eq!(named("LLVM"), Ok(1));
        assert_eq!(named("gl"), Ok(2));
        assert_eq!(named("some driver"), Ok(0));
    }

    #[test]
    fn a_name_without_a_match_lists_what_there_is() {
        let list = [facts("NVIDIA H200", "vulkan"), facts("llvmpipe", "vulkan")];
        let error = pick(&list, &AdapterChoice::Named("radeon".into())).unwrap_err();
        let text = error.to_string();
        assert!(text.contains("`radeon`") && text.contains("NVIDIA H200"), "{text}");
        assert!(text.contains("llvmpipe"), "{text}");
    }

    fn info(name: &str, driver: &str, device_type: wgpu::DeviceType) -> wgpu::AdapterInfo {
        let mut info = wgpu::AdapterInfo::new(device_type, wgpu::Backend::Vulkan);
        info.name = name.into();
        info.driver = driver.into();
        info
    }

    #[test]
    fn software_is_known_by_type_or_name() {
        use wgpu::DeviceType::{Cpu, DiscreteGpu, Other};
        assert_eq!(kind(&info("anything", "", Cpu)), AdapterKind::Software);
        assert_eq!(kind(&info("llvmpipe (LLVM 15)", "Mesa", Other)), AdapterKind::Software);
        assert_eq!(kind(&info("SwiftShader Device", "", Other)), AdapterKind::Software);
        assert_eq!(kind(&info("Microsoft Basic Render Driver", "", Other)), AdapterKind::Software);
        assert_eq!(kind(&info("NVIDIA H200", "NVIDIA", DiscreteGpu)), AdapterKind::Hardware);
    }

    #[test]
    fn hardware_sorts_before_software() {
        use wgpu::DeviceType::{Cpu, DiscreteGpu, IntegratedGpu};
        let mut list = [info("llvmpipe", "", Cpu), info("b", "", IntegratedGpu)].to_vec();
        list.push(info("a", "", DiscreteGpu));
        list.sort_by_key(rank);
        let names: Vec<_> = list.iter().map(|i| i.name.as_str()).collect();
        assert_eq!(names, ["a", "b", "llvmpipe"]);
    }
}
