//! Based on: Lance Williams, "Casting curved shadows on curved surfaces", SIGGRAPH 1978; William
//! T. Reeves, David H. Salesin, Robert L. Cook, "Rendering antialiased shadows with depth maps",
//! SIGGRAPH 1987, section 3.

use super::Real;

/// 0 where the stored occluder is nearer to the light than the receiver, else 1.
///
/// Percentage-closer filtering is the weighted mean of this over a window.
#[inline]
pub fn visibility<R: Real>(occluder: R, receiver: R) -> R {
    if occluder < receiver { R::of(0.0) } else { R::of(1.0) }
}

#[cfg(test)]
mod tests {
    #[test]
    fn equal_depth_is_lit() {
        assert_eq!(super::visibility(0.5, 0.5), 1.0);
        assert_eq!(super::visibility(0.5, 0.500_001), 0.0);
        assert_eq!(super::visibility(0.5f32, 0.499_999), 1.0);
    }
}
