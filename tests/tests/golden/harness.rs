//! The folder of references, and controls: what must fail does.

use crate::{cities, lights, night, partition, regions, shadows, translucent};
use dapple_tests::golden::{
    EXACT, LSB, Picture, RASTER, Tolerance, assert_golden_in, audit, compare, goldens_folder,
    reference,
};
use std::{fs, panic, path::Path};

/// How many there are: one that is lost from a list would not be missed.
const GOLDENS: usize = 81;

fn goldens() -> Vec<(String, Tolerance)> {
    let mut all = shadows::goldens();
    all.extend(translucent::goldens());
    all.extend(cities::goldens());
    all.extend(lights::goldens());
    all.extend(regions::goldens());
    all.extend(night::goldens());
    all.push((partition::NAME.into(), EXACT));
    all
}

/// Whether insta was told to replace references: then nothing can be missing.
fn blessing() -> bool {
    std::env::var("INSTA_UPDATE").is_ok_and(|v| v == "always" || v == "force" || v == "1")
}

#[test]
fn the_folder_holds_every_golden_and_nothing_else() {
    if blessing() {
        println!("not run: references are being replaced");
        return;
    }
    let all = goldens();
    assert_eq!(all.len(), GOLDENS);
    let wrong = audit(&goldens_folder(), all.iter().map(|(name, _)| name.as_str()));
    assert_eq!(wrong, Vec::<String>::new());
    for (name, _) in &all {
        let size = fs::metadata(goldens_folder().join(format!("{name}.snap.png"))).unwrap().len();
        assert!(size <= 16 * 1024, "{name}: {size} bytes");
    }
}

#[test]
fn a_stale_and_a_missing_file_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let touch = |name: &str| fs::write(folder.path().join(name), "").unwrap();
    for name in ["a.snap", "a.snap.png", "b.snap", "old.snap.png"] {
        touch(name);
    }
    let wrong = audit(folder.path(), ["a", "b", "c"]);
    let expected =
        ["missing: b.snap.png", "missing: c.snap", "missing: c.snap.png", "stale: old.snap.png"];
    assert_eq!(wrong, expected);
    assert_eq!(audit(&folder.path().join("absent"), ["a"]).len(), 2);
    assert!(audit(folder.path(), ["a", "old"]).contains(&"missing: old.snap".to_string()));
}

/// Every golden at the tolerances it is held to, moved by a pixel, brighter and darker by 3 %.
#[test]
fn a_mutated_picture_fails_for_every_golden() {
    if blessing() {
        println!("not run: references are being replaced");
        return;
    }
    let mut mutations = 0;
    for (name, tolerance) in goldens() {
        let golden = reference(&goldens_folder(), &name).unwrap();
        for tolerance in [tolerance, RASTER] {
            assert!(compare(&golden, &golden, tolerance).is_within(tolerance), "{name}");
            let mutated = [
                ("shifted", golden.shifted()),
                ("brightened", golden.brightened(0.03)),
                ("dimmed", golden.dimmed(0.97)),
            ];
            for (what, mutated) in mutated {
                let deviation = compare(&golden, &mutated, tolerance);
                assert!(
                    !deviation.is_within(tolerance),
                    "{name} {what} passes `{}`: {deviation}",
                    tolerance.name
                );
                mutations += 1;
            }
        }
    }
    assert_eq!(mutations, 6 * GOLDENS);
}

/// Runs an assertion that must fail; insta's own words go to standard error.
fn fails(goldens: &Path, failures: &Path, name: &str, actual: &Picture) -> bool {
    let assertion = || assert_golden_in(goldens, failures, name, actual, LSB);
    panic::catch_unwind(assertion).is_err()
}

#[test]
fn an_assertion_without_reference_fails_and_one_with_a_wrong_picture_leaves_three() {
    if blessing() {
        println!("not run: references are being replaced");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (goldens, failures) = (folder.path().join("goldens"), folder.path().join("failures"));
    fs::create_dir(&goldens).unwrap();
    let name = "spheres-truth";
    let right = reference(&goldens_folder(), name).unwrap();
    assert!(fails(&goldens, &failures, name, &right), "a missing reference passed");
    for ending in ["snap", "snap.png"] {
        let file = format!("{name}.{ending}");
        fs::copy(goldens_folder().join(&file), goldens.join(&file)).unwrap();
    }
    assert!(!fails(&goldens, &failures, name, &right), "the reference itself failed");
    assert!(!failures.exists());
    let wrong = right.shifted();
    assert!(fails(&goldens, &failures, name, &wrong), "a shifted picture passed");
    let read = |what: &str| {
        Picture::from_png(&fs::read(failures.join(format!("{name}-{what}.png"))).unwrap()).unwrap()
    };
    assert_eq!(read("expected"), right);
    assert_eq!(read("actual"), wrong);
    let lit = read("diff")
        .codes
        .iter()
        .zip(&right.codes)
        .zip(&wrong.codes)
        .all(|((d, a), b)| (*d == 0) == (a == b));
    assert!(lit, "the picture of differences does not show them");
    // A pass takes the pictures of the failure away.
    assert!(!fails(&goldens, &failures, name, &right));
    assert_eq!(fs::read_dir(&failures).unwrap().count(), 0);
    fs::remove_file(goldens.join(format!("{name}.snap.png"))).unwrap();
    assert!(fails(&goldens, &failures, name, &right), "a reference without its picture passed");
}
