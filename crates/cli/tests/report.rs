//! The page of real measurements, as a parser and a browser see it.

mod common;

use common::{run, said};
use std::{
    fs,
    io::Write,
    path::{Path, PathBuf},
    process::Command,
};

/// Makes a missing browser a failure.
const REQUIRE: &str = "DAPPLE_REQUIRE_BROWSER";

fn measured(folder: &Path) -> String {
    let measure = "measure shadow-filtering --scene half_plane --form cpu --technique vsm \
                   --technique hard --param width=64 --repeats 3";
    let output = run(folder, &measure.split_whitespace().collect::<Vec<_>>());
    assert!(output.status.success(), "{}", said(&output));
    let output = run(folder, &["report"]);
    assert!(output.status.success(), "{}", said(&output));
    fs::read_to_string(folder.join("report.html")).unwrap()
}

fn count(text: &str, part: &str) -> usize {
    text.matches(part).count()
}

fn browser() -> Option<PathBuf> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let folders: Vec<_> = std::env::split_paths(&std::env::var_os("PATH")?).collect();
    names.iter().flat_map(|n| folders.iter().map(move |f| f.join(n))).find(|p| p.is_file())
}

#[test]
fn measured_settings_are_on_the_page_with_their_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let page = measured(folder.path());
    // One front of two settings, each with truth, result and error.
    assert_eq!(count(&page, "<svg class=\"plot\""), 1);
    assert_eq!(count(&page, "<th class=\"w\" scope=\"row\">vsm/min-variance (cpu)"), 1);
    let pictures = count(&page, "data:image/png;base64,");
    assert!(pictures == 3 || pictures == 6, "{pictures} pictures");
    assert!(page.contains("dapple measure shadow-filtering --scene half_plane"));
    let without = run(folder.path(), &["report", "--no-pictures", "-o", "bare.html"]);
    assert!(without.status.success(), "{}", said(&without));
    let bare = fs::read_to_string(folder.path().join("bare.html")).unwrap();
    assert_eq!(count(&bare, "data:image/png"), 0);
    assert!(bare.contains("Pictures were left out."));
}

#[test]
fn a_case_that_is_gone_is_said_and_the_page_is_made_all_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let page = measured(at);
    assert!(!page.contains("No pictures of"));
    let records = fs::read_dir(at.join("records")).unwrap().next().unwrap().unwrap().path();
    let text = fs::read_to_string(&records).unwrap();
    fs::write(&records, text.replace("--scene half_plane", "--scene no_such_scene")).unwrap();
    let output = run(at, &["report"]);
    assert!(output.status.success(), "{}", said(&output));
    let page = fs::read_to_string(at.join("report.html")).unwrap();
    assert!(page.contains("No pictures of half_plane"), "{}", said(&output));
    assert_eq!(count(&page, "<svg class=\"plot\""), 1);
}

#[test]
fn what_cannot_be_read_or_written_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let output = run(at, &["report", "--records", "absent"]);
    assert_eq!(output.status.code(), Some(3), "{}", said(&output));
    assert!(said(&output).contains("absent"));
    fs::create_dir(at.join("records")).unwrap();
    let output = run(at, &["report", "-o", "no/such/folder.html"]);
    assert_eq!(output.status.code(), Some(3), "{}", said(&output));
    assert!(said(&output).contains("no/such/folder.html"));
    let output = run(at, &["report", "nothing"]);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
}

#[test]
fn a_browser_shows_it_without_a_word_of_complaint() {
    let Some(browser) = browser() else {
        let required = std::env::var_os(REQUIRE).is_some_and(|v| !v.is_empty() && v != "0");
        assert!(!required, "{REQUIRE} is set and no Chromium is on the path");
        // Past the harness's capture: a skip must not look like a pass.
        let _ = writeln!(std::io::stderr(), "not run: no Chromium to load the page with");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    measured(at);
    let (dom, log) = load(&browser, at, "report.html");
    assert!(count(&dom, "<circle") + count(&dom, "<path class=\"mark") >= 2, "{log}");
    for section in ["machines", "shadow-filtering", "failures", "again"] {
        assert!(dom.contains(&format!("<section id=\"{section}\"")), "{section}: {log}");
    }
    assert!(!log.contains("CONSOLE"), "{log}");
    // The control: a page that does load something from elsewhere is noticed.
    let broken = fs::read_to_string(at.join("report.html")).unwrap();
    let broken = broken.replace("</main>", "<script>console.error('heard')</script></main>");
    fs::write(at.join("broken.html"), broken).unwrap();
    let (_, log) = load(&browser, at, "broken.html");
    assert!(log.contains("CONSOLE"), "{log}");
    // The picture is drawn: what the window shows is not of one colour.
    let shot = at.join("shot.png");
    let screenshot = format!("--screenshot={}", shot.display());
    command(&browser, at, "report.html").arg(screenshot).output().unwrap();
    let image = image::open(&shot).unwrap().to_rgb8();
    let colours: std::collections::BTreeSet<_> = image.pixels().map(|p| p.0).collect();
    assert!(colours.len() > 16, "{} colours", colours.len());
}

fn command(browser: &Path, folder: &Path, page: &str) -> Command {
    let mut command = Command::new(browser);
    let flags = [
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--no-first-run",
        "--disable-background-networking",
        "--disable-component-update",
        "--disable-sync",
        "--enable-logging=stderr",
        "--window-size=1000,2000",
    ];
    command
        .args(flags)
        .arg(format!("--user-data-dir={}", folder.join("profile").display()))
        .arg(format!("file://{}", folder.join(page).display()));
    command
}

/// The page as the browser built it, and what it logged.
fn load(browser: &Path, folder: &Path, page: &str) -> (String, String) {
    let output = command(browser, folder, page).arg("--dump-dom").output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (text(&output.stdout), text(&output.stderr))
}
