//! The pages say what the program does: generated blocks are made again and compared (times are
//! not), links and paths resolve, and command lines name verbs and flags that exist.
//!
//! A block stands between `<!-- generated: COMMAND -->` and `<!-- end -->`. `COMMAND` is a command
//! line of the program; ` | techniques` or ` | knobs` after it names a view of its CSV. With
//! `DAPPLE_BLESS=1` the blocks and pictures are rewritten, which a build server refuses to do.

mod common;

mod docs_support;

use std::io::Write;

use docs_support::{
    blocks::{self, Made},
    commands, links, pages, pictures,
};

/// A page that grew by mistake would still pass every other test.
const README_LINES: usize = 140;

#[test]
fn generated_blocks_are_what_the_program_prints() {
    let bless = std::env::var_os("DAPPLE_BLESS").is_some();
    assert!(
        !bless || std::env::var_os("CI").is_none(),
        "DAPPLE_BLESS is for people: a build server must not rewrite what it checks"
    );
    let folder = tempfile::tempdir().unwrap();
    let (mut compared, mut stale) = (0, Vec::new());
    for page in pages::all() {
        let mut text = page.text.clone();
        for block in blocks::find(&page.text).unwrap_or_else(|e| panic!("{}: {e}", page.name)) {
            let body = match blocks::make(&block.command, folder.path(), &page.name) {
                Made::Body(body) => body,
                Made::NotRun(why) => {
                    assert!(
                        std::env::var_os("DAPPLE_REQUIRE_GPU").is_none(),
                        "{}: {why}",
                        block.command
                    );
                    let _ = writeln!(std::io::stderr(), "not run: {}: {why}", block.command);
                    continue;
                }
            };
            compared += 1;
            let name = format!("{}: `{}`", page.name, block.command);
            if let Some(output) = pictures::folder(&block.command) {
                stale.extend(
                    pictures::compare(folder.path(), &output, bless)
                        .map(|d| format!("{name}: {d}")),
                );
            }
            if bless {
                text = text.replace(&block.whole, &block.with(&body));
            } else if let Some(difference) = blocks::difference(&block.body, &body) {
                stale.push(format!("{name}: {difference}"));
            }
        }
        if bless && text != page.text {
            std::fs::write(&page.path, text).unwrap();
        }
    }
    assert!(compared >= 8, "only {compared} blocks were compared");
    assert!(stale.is_empty(), "stale; DAPPLE_BLESS=1 rewrites:\n{}", stale.join("\n"));
}

#[test]
fn links_and_paths_resolve() {
    let (mut checked, mut broken) = (0, Vec::new());
    for page in pages::all() {
        let (count, found) = links::broken(&page);
        checked += count;
        broken.extend(found);
    }
    assert!(checked >= 40, "only {checked} links and paths were seen");
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn command_lines_name_what_there_is() {
    let known = commands::Known::new();
    let (mut checked, mut wrong) = (0, Vec::new());
    for page in pages::all() {
        for command in commands::of(&page.text) {
            checked += 1;
            wrong.extend(
                known.objection(&command).map(|why| format!("{}: `{command}`: {why}", page.name)),
            );
        }
    }
    assert!(checked >= 15, "only {checked} command lines were seen");
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn the_readme_stays_short() {
    let readme = pages::all().into_iter().find(|p| p.name == "README.md").unwrap();
    let lines = readme.text.lines().count();
    assert!((40..=README_LINES).contains(&lines), "{lines} lines");
}

/// Every technique has its paragraph on its problem's page.
#[test]
fn every_technique_is_on_its_problems_page() {
    let mut checked = 0;
    for problem in dapple_suite::problems::ALL {
        let spec = problem.spec();
        let name = format!("docs/{}.md", spec.id);
        let page = pages::all().into_iter().find(|p| p.name == name);
        let page = page.unwrap_or_else(|| panic!("{name} is missing"));
        for technique in spec.techniques {
            checked += 1;
            assert!(
                pages::has_paragraph(&page.text, technique.id),
                "{name}: no `{}`",
                technique.id
            );
        }
        assert!(!pages::has_paragraph(&page.text, "nobodys-filter"));
    }
    assert!(checked >= 15);
}

/// Controls: each kind of rot is reported, and a changed time is not.
#[test]
fn rot_is_reported() {
    let row = " *  vsm/plain  1.51 ms  1%  1.000  0.05822  0.01042  2.0 MiB  bias=0.0 ";
    let slower = "    vsm/plain  9.99 µs  17%  3.1  0.05822  0.01042  2.0 MiB  bias=0.0 ";
    assert_eq!(blocks::difference(row, slower), None);
    for (from, to) in [
        ("0.05822", "0.05823"),
        ("0.01042", "0.01043"),
        ("2.0 MiB", "2.5 MiB"),
        ("bias=0.0", "bias=0.1"),
        ("vsm", "esm"),
    ] {
        assert!(blocks::difference(row, &row.replace(from, to)).is_some(), "{from} -> {to}");
    }
    assert!(blocks::difference(row, "").is_some());
    assert!(blocks::difference(row, &format!("{row}\n{row}")).is_some());
    assert!(blocks::find("<!-- generated: dapple list -->\nno end").is_err());

    let page = pages::Page::of("docs/x.md", "[a](no/such.md) `crates/no_such.rs` `crates/cli`");
    assert_eq!(links::broken(&page).1.len(), 2);

    let known = commands::Known::new();
    assert_eq!(known.objection("dapple measure shadow-filtering --knob bias=0"), None);
    for wrong in [
        "dapple measrue --sweep quick",
        "dapple measure --sweeep quick",
        "dapple measure shadow-filterin",
        "dapple measure shadow-filtering --scene carr",
        "dapple measure shadow-filtering --technique vsmm",
        "dapple render shadow-filtering vsm/maximum",
        "dapple scene generat car -o x.glb",
    ] {
        assert!(known.objection(wrong).is_some(), "{wrong}");
    }

    let picture = pictures::Image::filled(8, 4, [10, 20, 30]);
    assert_eq!(pictures::difference(&picture, &picture), None);
    let mut other = picture.clone();
    for x in 0..8 {
        other.set(x, 2, [255, 20, 30]);
    }
    assert!(pictures::difference(&picture, &other).is_some());
    assert!(pictures::difference(&picture, &pictures::Image::filled(8, 5, [10, 20, 30])).is_some());
}
