//! Validation of resolved WGSL, and the layout of its structs, both by naga.

use naga::valid::{Capabilities, ValidationFlags, Validator};

use crate::ShaderError;

/// What our shaders may use beyond plain WGSL. Every member must also be a feature that
/// `dapple-gpu` asks its device for.
fn capabilities() -> Capabilities {
    Capabilities::default()
        | Capabilities::SHADER_FLOAT16
        // pack2x16float and unpack2x16float; every backend but the oldest GL has them.
        | Capabilities::SHADER_FLOAT16_IN_FLOAT32
        | Capabilities::SUBGROUP
}

/// Size and field offsets of one WGSL struct, in bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    /// Size with trailing padding: the stride in an array.
    pub size: u32,
    /// Name and offset of each field, in order.
    pub fields: Vec<(String, u32)>,
}

/// Parses and validates resolved WGSL; `path` only names it in errors.
///
/// # Errors
/// [`ShaderError::Parse`] or [`ShaderError::Invalid`].
pub fn validate(path: &str, source: &str) -> Result<(), ShaderError> {
    checked(path, source).map(|_| ())
}

/// Layout of the struct `name` of a resolved WGSL text.
///
/// # Errors
/// [`ShaderError::Parse`], or [`ShaderError::NoStruct`] with the names there are.
pub fn struct_layout(source: &str, name: &str) -> Result<Layout, ShaderError> {
    let module = parse("struct_layout()", source)?;
    let mut have = Vec::new();
    for (_, ty) in module.types.iter() {
        let naga::TypeInner::Struct { members, span } = &ty.inner else { continue };
        if ty.name.as_deref() == Some(name) {
            let fields =
                members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset)).collect();
            return Ok(Layout { size: *span, fields });
        }
        have.extend(ty.name.clone());
    }
    Err(ShaderError::NoStruct { name: name.into(), have: have.join(", ") })
}

fn parse(path: &str, source: &str) -> Result<naga::Module, ShaderError> {
    let mut options = naga::front::wgsl::Options::new();
    options.capabilities = capabilities();
    naga::front::wgsl::Frontend::new_with_options(options)
        .parse(source)
        .map_err(|e| ShaderError::Parse { path: path.into(), message: e.emit_to_string(source) })
}

fn checked(path: &str, source: &str) -> Result<naga::Module, ShaderError> {
    let module = parse(path, source)?;
    Validator::new(ValidationFlags::all(), capabilities()).validate(&module).map_err(|e| {
        ShaderError::Invalid { path: path.into(), message: e.emit_to_string(source) }
    })?;
    Ok(module)
}
