//! Frames reuse what they need: alone in its process, because it counts objects of the process.

use dapple_gpu::testing::{live_objects, test_gpu};

#[test]
fn a_hundred_frames_leave_no_object_behind() {
    let Some(gpu) = test_gpu() else { return };
    let iterations = gpu.upload("iterations", &[1u32]).unwrap();
    let result = gpu.buffer("result", 4 * 16_384).unwrap();
    let pipeline = gpu.compute("gpu/work.wgsl", "work", &[]).unwrap();
    let group = gpu.bind(&pipeline, 0, &[&iterations, &result]);
    let frames = |count| {
        for _ in 0..count {
            let mut frame = gpu.frame();
            for name in ["a", "b"] {
                frame.compute(name, |pass| {
                    pass.set_pipeline(&pipeline);
                    pass.set_bind_group(0, &group, &[]);
                    pass.dispatch_workgroups(1, 1, 1);
                });
            }
            frame.finish().unwrap();
            // A frame that is dropped returns its pool too.
            drop(gpu.frame());
        }
    };
    frames(5);
    let before = live_objects().unwrap();
    assert!(before.iter().sum::<usize>() >= 4, "nothing is counted: {before:?}");
    let resident_before = resident_bytes();
    frames(100);
    assert_eq!(live_objects().unwrap(), before);
    if let (Some(before), Some(after)) = (resident_before, resident_bytes()) {
        let grown = after.saturating_sub(before);
        assert!(grown < 4 << 20, "resident memory grew by {grown} bytes");
    }

    // Control: the count does see an object that stays.
    let kept = gpu.buffer("kept", 16).unwrap();
    assert_ne!(live_objects().unwrap(), before);
    drop(kept);
}

/// Resident memory of this process, where the system tells it in /proc.
fn resident_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    let pages: u64 = text.split_whitespace().nth(1)?.parse().ok()?;
    Some(pages * 4096)
}
