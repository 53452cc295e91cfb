//! Accessors, with every size checked against the buffer before a byte is read.

use super::Reader;
use crate::SceneError;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Index, accessor::Accessor, buffer::View};

/// Bytes of one component.
fn size(kind: ComponentType) -> usize {
    match kind {
        ComponentType::I8 | ComponentType::U8 => 1,
        ComponentType::I16 | ComponentType::U16 => 2,
        ComponentType::U32 | ComponentType::F32 => 4,
    }
}

/// One component as a number, scaled to -1..=1 or 0..=1 if `normalised`.
fn component(kind: ComponentType, bytes: &[u8], normalised: bool) -> f64 {
    let unit = |x: f64, max: f64| if normalised { (x / max).max(-1.0) } else { x };
    match (kind, bytes) {
        (ComponentType::I8, &[a, ..]) => unit(f64::from(a as i8), 127.0),
        (ComponentType::U8, &[a, ..]) => unit(f64::from(a), 255.0),
        (ComponentType::I16, &[a, b, ..]) => unit(f64::from(i16::from_le_bytes([a, b])), 32767.0),
        (ComponentType::U16, &[a, b, ..]) => unit(f64::from(u16::from_le_bytes([a, b])), 65535.0),
        (ComponentType::U32, &[a, b, c, d, ..]) => f64::from(u32::from_le_bytes([a, b, c, d])),
        (ComponentType::F32, &[a, b, c, d, ..]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        // Not reached: slices are cut to `size(kind)`. NaN is refused by validation.
        _ => f64::NAN,
    }
}

impl Reader<'_> {
    /// The bytes of a view from `offset` on.
    fn view(&self, view: Index<View>, offset: u64, element: &str) -> Result<&[u8], SceneError> {
        let bytes = (|| {
            let view = self.root.buffer_views.get(view.value())?;
            let buffer = self.buffers.get(view.buffer.value())?;
            let start = view.byte_offset.unwrap_or_default().0;
            let end = start.checked_add(view.byte_length.0)?;
            let whole = buffer.get(usize::try_from(start).ok()?..usize::try_from(end).ok()?)?;
            whole.get(usize::try_from(offset).ok()?..)
        })();
        bytes.ok_or_else(|| {
            let reason =
                format!("buffer view {} with offset {offset} exceeds its buffer", view.value());
            self.error(element, reason)
        })
    }

    /// An image's bytes.
    pub(super) fn view_bytes(&self, view: Index<View>, element: &str) -> Result<&[u8], SceneError> {
        self.view(view, 0, element)
    }

    /// `count` items of `width` components each from a view; `stride` 0 means packed.
    #[expect(clippy::too_many_arguments, reason = "an accessor is this many numbers")]
    fn items(
        &self,
        element: &str,
        view: Index<View>,
        offset: u64,
        stride: usize,
        count: usize,
        width: usize,
        (kind, normalised): (ComponentType, bool),
    ) -> Result<Vec<f64>, SceneError> {
        let bytes = self.view(view, offset, element)?;
        let item = width * size(kind);
        let stride = if stride == 0 { item } else { stride };
        let need = match count {
            0 => 0,
            n => (n - 1).saturating_mul(stride).saturating_add(item),
        };
        if need > bytes.len() || stride < item {
            let have = bytes.len();
            let reason = format!(
                "{count} items of {item} bytes, stride {stride}, need {need} bytes of {have}"
            );
            return Err(self.error(element, reason));
        }
        let mut out = Vec::with_capacity(count * width);
        for i in 0..count {
            let at = i * stride;
            let parts = bytes[at..at + item].chunks_exact(size(kind));
            out.extend(parts.map(|part| component(kind, part, normalised)));
        }
        Ok(out)
    }

    /// All components of an accessor of `width` components an item.
    fn flat(
        &self,
        index: Index<Accessor>,
        what: &str,
        width: usize,
    ) -> Result<Vec<f64>, SceneError> {
        let element = format!("accessor {} ({what})", index.value());
        let fail = |reason: &str| self.error(&*element, reason);
        let a = self.root.accessors.get(index.value()).ok_or_else(|| fail("does not exist"))?;
        let wanted = [Type::Scalar, Type::Vec2, Type::Vec3, Type::Vec4].get(width - 1).copied();
        let (Checked::Valid(kind), true) =
            (a.component_type, wanted.is_some_and(|t| a.type_ == Checked::Valid(t)))
        else {
            return Err(fail(&format!("needs items of {width} components")));
        };
        let count = usize::try_from(a.count.0).map_err(|_| fail("has too many items"))?;
        let format = (kind.0, a.normalized);
        let mut values = match a.buffer_view {
            Some(view) => {
                let stride = self.root.buffer_views.get(view.value()).and_then(|v| v.byte_stride);
                let stride = stride.map_or(0, |s| s.0);
                let offset = a.byte_offset.unwrap_or_default().0;
                self.items(&element, view, offset, stride, count, width, format)?
            }
            // All zeros but for sparse items: nothing in the file bounds the count.
            None if count > 1 << 24 => return Err(fail("has over 2^24 items and no buffer view")),
            None => vec![0.0; count * width],
        };
        if let Some(sparse) = &a.sparse {
            let many = usize::try_from(sparse.count.0).map_err(|_| fail("sparse count"))?;
            let Checked::Valid(index_kind) = sparse.indices.component_type else {
                return Err(fail("sparse indices have an unknown type"));
            };
            let at = &sparse.indices;
            let (view, offset) = (at.buffer_view, at.byte_offset.0);
            let places = self.items(&element, view, offset, 0, many, 1, (index_kind.0, false))?;
            let (view, offset) = (sparse.values.buffer_view, sparse.values.byte_offset.0);
            let items = self.items(&element, view, offset, 0, many, width, format)?;
            for (place, item) in places.iter().zip(items.chunks_exact(width)) {
                let start = *place as usize * width;
                let target = values.get_mut(start..start + width);
                target.ok_or_else(|| fail("sparse index out of range"))?.copy_from_slice(item);
            }
        }
        Ok(values)
    }

    /// An accessor of vectors, rounded to `f32` (exact for all component types but `u32`).
    pub(super) fn vectors<const N: usize>(
        &self,
        index: Index<Accessor>,
        what: &str,
    ) -> Result<Vec<[f32; N]>, SceneError> {
        let flat = self.flat(index, what, N)?;
        Ok(flat.chunks_exact(N).map(|v| std::array::from_fn(|i| v[i] as f32)).collect())
    }

    /// An accessor of vertex indices.
    pub(super) fn indices(&self, index: Index<Accessor>) -> Result<Vec<u32>, SceneError> {
        let flat = self.flat(index, "indices", 1)?;
        if let Some((i, &x)) = flat
            .iter()
            .enumerate()
            .find(|&(_, &x)| !(0.0..=f64::from(u32::MAX)).contains(&x) || x.fract() != 0.0)
        {
            let element = format!("accessor {} (indices), item {i}", index.value());
            return Err(self.error(element, format!("{x} is not an index")));
        }
        Ok(flat.into_iter().map(|x| x as u32).collect())
    }
}
