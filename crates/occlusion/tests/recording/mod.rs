//! Reads what the recorder of GameTechDev/MaskedOcclusionCulling writes: the meshes drawn and the
//! questions asked between two clears, with their matrices.
//!
//! Little endian: a signature, `f32` near, `u32` width and height, then records: a kind (`u8`) and
//! its fields, as read below. Matrices are column by column for column vectors; depth is 1 / w.

use glam::{Mat4, Vec3, Vec4};

/// One mesh of the recording.
pub struct Mesh {
    pub positions: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    /// To clip space, with reversed depth: z is the near plane's distance.
    pub clip: Mat4,
    /// Which triangles are not drawn: 0 none, 1 clockwise, 2 counter-clockwise, y up.
    pub back: u32,
}

/// The meshes drawn, in order.
pub struct Recording {
    pub near: f32,
    pub width: u32,
    pub height: u32,
    pub meshes: Vec<Mesh>,
}

impl Recording {
    pub fn triangles(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.triangles.len()).sum()
    }
}

const SIGNATURE: u32 = 0xa701_b600;

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let end = self.at.checked_add(count).filter(|&end| end <= self.bytes.len());
        let end = end.ok_or_else(|| {
            format!("byte {}: {count} more were expected, {} are there", self.at, self.bytes.len())
        })?;
        let taken = &self.bytes[self.at..end];
        self.at = end;
        Ok(taken)
    }

    fn u32(&mut self) -> Result<u32, String> {
        let bytes = self.take(4)?;
        Ok(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
    }

    fn f32(&mut self) -> Result<f32, String> {
        self.u32().map(f32::from_bits)
    }
}

/// Reads a recording.
pub fn read(bytes: &[u8]) -> Result<Recording, String> {
    let mut reader = Reader { bytes, at: 0 };
    if reader.u32()? != SIGNATURE {
        return Err("byte 0: not the signature of a recording".to_owned());
    }
    let (near, width, height) = (reader.f32()?, reader.u32()?, reader.u32()?);
    let mut meshes = Vec::new();
    loop {
        let start = reader.at;
        match reader.take(1)?[0] {
            // A rectangle asked about.
            1 => drop(reader.take(4 + 5 * 4)?),
            // Triangles asked about are read and left out, triangles drawn are kept.
            kind @ (0 | 2) => meshes.extend(mesh(&mut reader, near)?.filter(|_| kind == 0)),
            3 => {}
            4 => {
                if reader.u32()? != 0 {
                    return Err(format!("byte {start}: parallel projections are not supported"));
                }
            }
            0x7f => break,
            other => return Err(format!("byte {start}: unknown record {other:#x}")),
        }
    }
    Ok(Recording { near, width, height, meshes })
}

fn mesh(reader: &mut Reader, near: f32) -> Result<Option<Mesh>, String> {
    let _result = reader.u32()?;
    let count = reader.u32()? as usize;
    if count == 0 {
        return Ok(None);
    }
    let start = reader.at;
    let stride = reader.u32()? as usize;
    let vertices = reader.take(count.saturating_mul(stride))?;
    let triangle_count = reader.u32()? as usize;
    let indices = reader.take(triangle_count.saturating_mul(12))?;
    let matrix = if reader.take(1)?[0] == 0 {
        Mat4::IDENTITY
    } else {
        let mut elements = [0.0; 16];
        for element in &mut elements {
            *element = reader.f32()?;
        }
        Mat4::from_cols_array(&elements)
    };
    let (_planes, back) = (reader.u32()?, reader.u32()?);
    let [layout_stride, y, w] = [reader.u32()?, reader.u32()?, reader.u32()?].map(|v| v as usize);
    if layout_stride != stride || [y, w].iter().any(|&offset| offset + 4 > stride) {
        return Err(format!("byte {start}: the layout does not fit {stride} bytes a corner"));
    }
    let float = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    let positions = vertices
        .chunks_exact(stride)
        .map(|v| Vec3::new(float(v), float(&v[y..]), float(&v[w..])))
        .collect();
    let index = |bytes: &[u8]| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    let triangles: Vec<[u32; 3]> =
        indices.chunks_exact(12).map(|t| [index(t), index(&t[4..]), index(&t[8..])]).collect();
    if triangles.iter().flatten().any(|&corner| corner as usize >= count) {
        return Err(format!("byte {start}: an index of no corner, there are {count}"));
    }
    // Its own depth is not needed: ours is near / w.
    let rows = matrix.transpose();
    let reversed = Vec4::new(0.0, 0.0, 0.0, near);
    let clip = Mat4::from_cols(rows.x_axis, rows.y_axis, reversed, rows.w_axis).transpose();
    Ok(Some(Mesh { positions, triangles, clip, back }))
}
