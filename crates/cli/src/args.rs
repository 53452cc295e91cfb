//! The command line.

use clap::{Args as ClapArgs, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Measures, for real-time rendering techniques, what speed costs in accuracy.
#[derive(Parser)]
#[command(
    name = "dapple",
    version,
    about,
    after_help = "\
Examples:
  dapple measure --sweep quick                              time and error of every technique
  dapple measure shadow-filtering --scene oak.glb           the same on a scene of yours
  dapple front shadow-filtering                             the last front from the records
  dapple verify                                             correctness gates, exit 1 if broken
  dapple claims shadow-filtering                            what the sources say, judged
  dapple stress shadow-filtering --axis scale               where it breaks
  dapple advise shadow-filtering --scene oak.glb            the cheapest that is good enough
  dapple compare old.jsonl records                          faster, slower, better, worse
  dapple report -o report.html                              everything on one page
  dapple render shadow-filtering vsm --scene car -o out/    picture, truth and error map

Exit codes: 0 ok, 1 a check failed, 2 usage or bad input, 3 environment."
)]
pub struct Args {
    /// What to do; without a verb: the state of the records and what to try next.
    #[command(subcommand)]
    pub verb: Option<Verb>,
}

/// The verbs.
#[derive(Subcommand)]
pub enum Verb {
    /// Problems, techniques, knobs, sweeps and scenes there are.
    List(List),
    /// Adapters, features, limits, and what the soundness probes found.
    Doctor(Doctor),
    /// Measure time and error side by side; prints the front.
    Measure(Measure),
    /// Print fronts of error against time from records.
    Front(Front),
    /// Run the correctness gates and their negative controls; exit 1 if one is broken.
    Verify(Verify),
    /// Judge the hypotheses of the sources, with figures.
    Claims(Claims),
    /// Push techniques to the extremes a problem declares; prints where each is safe.
    Stress(Stress),
    /// Find the cheapest technique and setting that is good enough for a scene.
    Advise(Advise),
    /// Compare two runs: what got faster, slower, better or worse beyond noise.
    Compare(Compare),
    /// Write one self-contained HTML page from records.
    Report(Report),
    /// Join records of shards or machines into one file.
    Merge(Merge),
    /// Write records in another format.
    Export(Export),
    /// Render one technique: result, truth and error map as PNG.
    Render(Render),
    /// Inspect or generate scenes.
    Scene(Scene),
    /// One group of a run, from standard input: the runner starts this.
    #[command(hide = true)]
    RunGroup,
    /// One axis of `stress`, from standard input: `stress` starts this.
    #[command(hide = true)]
    StressAxis,
    /// What there is, as one JSON line: the dashboard starts this.
    #[command(hide = true)]
    Catalogue,
    /// Shows settings as they are asked for on standard input: the dashboard starts this.
    #[command(hide = true)]
    Live(Live),
}

/// How results are printed on standard output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For people.
    #[default]
    Table,
    /// One JSON object a line.
    Jsonl,
    /// Comma-separated, with a header.
    Csv,
}

/// Arguments of `list`.
#[derive(ClapArgs)]
pub struct List {
    /// A problem: lists its techniques with variants and knobs.
    pub problem: Option<String>,
    /// Output format.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Arguments of `doctor`.
#[derive(ClapArgs)]
pub struct Doctor {
    /// Part of an adapter's or backend's name.
    #[arg(long)]
    pub adapter: Option<String>,
}

/// Which case, for verbs that work on one.
#[derive(ClapArgs)]
pub struct CaseArgs {
    /// Generator name, file, or `data:PATH` below DAPPLE_DATA.
    #[arg(long)]
    pub scene: Vec<String>,
    /// Name of a camera, or of a path where the problem follows one,
    /// `orbit:AZIMUTH,ELEVATION,DISTANCE` or `eye:X,Y,Z,TX,TY,TZ`; the first if not given
    #[arg(long)]
    pub view: Option<String>,
    /// Seed of generators and sampling.
    #[arg(long)]
    pub seed: Option<u64>,
    /// Case parameter, NAME=VALUE[,VALUE...]; `dapple list PROBLEM` shows them.
    #[arg(long = "param", value_name = "NAME=VALUE")]
    pub parameters: Vec<String>,
}

/// Arguments of `measure`.
#[derive(ClapArgs)]
#[command(after_help = "\
Examples:
  dapple measure --sweep quick
  dapple measure shadow-filtering --scene tree.obj --knob resolution=512,1024
  dapple measure shadow-filtering --scene car --technique vsm --technique msm --form gpu

A run that was stopped goes on where it stopped when the same command is given again.")]
pub struct Measure {
    /// Problem; or give --sweep.
    #[arg(conflicts_with = "sweep")]
    pub problem: Option<String>,
    /// Named sweep or TOML file.
    #[arg(long, conflicts_with_all = ["scene", "view", "seed", "parameters", "technique", "knob", "form"])]
    pub sweep: Option<String>,
    /// The case.
    #[command(flatten)]
    pub case: CaseArgs,
    /// Technique or TECHNIQUE/VARIANT (variant * for all); repeatable; all if not given.
    #[arg(long)]
    pub technique: Vec<String>,
    /// Knob NAME=VALUE[,VALUE...] for every technique that has it; repeatable.
    #[arg(long, value_name = "NAME=VALUE")]
    pub knob: Vec<String>,
    /// Form: cpu, gpu; both if not given.
    #[arg(long)]
    pub form: Vec<String>,
    /// Part of an adapter's or backend's name.
    #[arg(long)]
    pub adapter: Option<String>,
    /// Timed repeats [default: the sweep's, or 5].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub repeats: Option<u32>,
    /// Folder of the records.
    #[arg(long, default_value = "records")]
    pub records: PathBuf,
    /// Begin anew even if an unfinished run of the same work is there.
    #[arg(long)]
    pub fresh: bool,
    /// Only part I of N of the work, e.g. 0/4: the parts are disjoint, and together the whole.
    #[arg(long, value_name = "I/N")]
    pub shard: Option<String>,
    /// Tell what happens as JSON lines on standard output, for a dashboard.
    #[arg(long, hide = true)]
    pub feed: bool,
    /// Output format.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// A deliberate fault of the measured process, KIND:TECHNIQUE, to test the runner.
    #[arg(long, hide = true)]
    pub fault: Option<String>,
}

/// Arguments of `front`.
#[derive(ClapArgs)]
pub struct Front {
    /// Problem; all if not given.
    pub problem: Option<String>,
    /// Record file or folder.
    #[arg(long, default_value = "records")]
    pub records: PathBuf,
    /// Error metric; the problem's axis metric if not given.
    #[arg(long)]
    pub metric: Option<String>,
    /// Also print dominated settings.
    #[arg(long)]
    pub all: bool,
    /// Output format.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Output of `verify`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum VerifyFormat {
    /// For people.
    #[default]
    Table,
    /// One JSON object a gate.
    Jsonl,
    /// JUnit XML.
    Junit,
}

/// Arguments of `verify`.
#[derive(ClapArgs)]
pub struct Verify {
    /// Problem; all if not given.
    pub problem: Option<String>,
    /// Only this technique's gates.
    #[arg(long)]
    pub technique: Option<String>,
    /// Random cases a property [default: 64, or PROPTEST_CASES].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    pub cases: Option<u32>,
    /// Seed of random input.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Look for rare failures a hundred times as long: ten million rays and more.
    #[arg(long)]
    pub deep: bool,
    /// Part of an adapter's or backend's name.
    #[arg(long)]
    pub adapter: Option<String>,
    /// Folder of the records.
    #[arg(long, default_value = "records")]
    pub records: PathBuf,
    /// Tell what happens as JSON lines on standard output, for a dashboard.
    #[arg(long, hide = true)]
    pub feed: bool,
    /// Output format.
    #[arg(long, value_enum, default_value_t)]
    pub format: VerifyFormat,
}

/// Arguments of `claims`.
#[derive(ClapArgs)]
pub struct Claims {
    /// Problem; all if not given.
    pub problem: Option<String>,
    /// Only the claim of this id.
    #[arg(long)]
    pub id: Option<String>,
    /// Part of an adapter's or backend's name.
    #[arg(long)]
    pub adapter: Option<String>,
    /// Folder of the records.
    #[arg(long, default_value = "records")]
    pub records: PathBuf,
    /// Tell what happens as JSON lines on standard output, for a dashboard.
    #[arg(long, hide = true)]
    pub feed: bool,
    /// Output format.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Arguments of `stress`.
#[derive(ClapArgs)]
#[command(after_help = "\
Examples:
  dapple stress shadow-filtering
  dapple stress shadow-filtering --axis scale --axis offset --technique vsm
  dapple stress shadow-filtering --axis depth-range --technique msm --at 1e4 -o out/

Exit code 1 if a technique accepted what it must refuse, or crashed.")]
pub struct Stress {
    /// Problem; all if not given.
    pub problem: Option<String>,
    /// Axis; repeatable; all if not given.
    #[arg(long)]
    pub axis: Vec<String>,
    /// Technique or TECHNIQUE/VARIANT; repeatable; all if not given.
    #[arg(long)]
    pub technique: Vec<String>,
    /// Form: cpu, gpu; those the axis names if not given.
    #[arg(long)]
    pub form: Vec<String>,
    /// The case that the axes start from.
    #[command(flatten)]
    pub case: CaseArgs,
    /// Only this value of the one axis named (a number or a word), with its pictures.
    #[arg(long, allow_hyphen_values = true)]
    pub at: Option<String>,
    /// Folder for the pictures of --at.
    #[arg(short, long, requires = "at")]
    pub output: Option<PathBuf>,
    /// Bisection steps at each end of the safe set.
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u32).range(0..=40))]
    pub refine: u32,
    /// Seconds one point may take.
    #[arg(long, default_value_t = 60, value_parser = clap::value_parser!(u64).range(1..))]
    pub limit: u64,
    /// Part of an adapter's or backend's name.
    #[arg(long)]
    pub adapter: Option<String>,
    /// Folder of the records.
    #[arg(long, default_value = "records")]
    pub records: PathBuf,
    /// Begin anew even if an unfinished run of the same work is there.
    #[arg(long)]
    pub fresh: bool,
    /// Tell what happens as JSON lines on standard output, for a dashboard.
    #[arg(long, hide = true)]
    pub feed: bool,
    /// Output format.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// A deliberate fault of the pushing process, KIND:TECHNIQUE[@VALUE], to test the runner.
    #[arg(long, hide = true)]
    pub fault: Option<String>,
}

/// Arguments of `advise`.
#[derive(ClapArgs)]
#[command(after_help = "\
Examples:
  dapple advise shadow-filtering --scene oak.glb --error 0.02
  dapple advise shadow-filtering --scene oak.glb --error 0.05 --metric flip
  dapple advise shadow-filtering --scene oak.glb --budget-ms 4
  dapple advise shadow-filtering --scene oak.glb                 the knee of the front")]
pub struct Advise {
    /// Problem.
    pub problem: String,
    /// The case.
    #[command(flatten)]
    pub case: CaseArgs,
    /// Greatest error that is good enough.
    #[arg(long, conflicts_with = "budget_ms")]
    pub error: Option<f64>,
    /// Error metric; the problem's axis metric if not given.
    #[arg(long)]
    pub metric: Option<String>,
    /// Milliseconds a frame may take.
    #[arg(long)]
    pub budget_ms: Option<f64>,
    /// Time to spend, e.g. 60s or 5m.
    #[arg(long, default_value = "60s")]
    pub time: String,
    /// Technique or TECHNIQUE/VARIANT to choose from; repeatable; all if not given.
    #[arg(long)]
    pub technique: Vec<String>,
    /// Form: cpu or gpu [default: gpu where there is a hardware adapter, else cpu].
    #[arg(long)]
    pub form: Option<String>,
    /// Part of an adapter's or backend's name.
    #[arg(long)]
    pub adapter: Option<String>,
    /// Folder of the records.
    #[arg(long, default_value = "records")]
    pub records: PathBuf,
    /// Output format.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
}

/// Output of `compare`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum CompareFormat {
    /// For people.
    #[default]
    Table,
    /// One JSON object a row.
    Jsonl,
    /// For a pull request.
    Markdown,
}

/// What makes `compare` fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FailOn {
    /// A time above the old one beyond noise.
    Slower,
    /// An error above the old one beyond the threshold, or a row that now fails.
    Worse,
    /// A counter that changed.
    Counters,
    /// A row that is there no more.
    Gone,
}

/// Arguments of `compare`.
#[derive(ClapArgs)]
#[command(after_help = "\
Examples:
  dapple compare old.jsonl new.jsonl
  dapple compare benches/baseline records --fail-on worse,counters --any-machine
  dapple compare old new --format markdown >> \"$GITHUB_STEP_SUMMARY\"

Exit code 1 if something that --fail-on names happened.")]
pub struct Compare {
    /// Record file or folder, before.
    pub old: PathBuf,
    /// Record file or folder, after.
    pub new: PathBuf,
    /// Changes smaller than this share are none.
    #[arg(long, default_value_t = 0.05)]
    pub threshold: f64,
    /// Exit 1 on these; several with commas.
    #[arg(long, value_enum, value_delimiter = ',')]
    pub fail_on: Vec<FailOn>,
    /// Join rows of different machines too: their errors and counters may be compared, times not.
    #[arg(long)]
    pub any_machine: bool,
    /// Print rows without a change too.
    #[arg(long)]
    pub all: bool,
    /// Output format.
    #[arg(long, value_enum, default_value_t)]
    pub format: CompareFormat,
}

/// Arguments of `report`.
#[derive(ClapArgs)]
pub struct Report {
    /// Problem; all if not given.
    pub problem: Option<String>,
    /// Record file or folder.
    #[arg(long, default_value = "records")]
    pub records: PathBuf,
    /// The page.
    #[arg(short, long, default_value = "report.html")]
    pub output: PathBuf,
    /// Leave the pictures out: they are rendered anew from the cases.
    #[arg(long)]
    pub no_pictures: bool,
}

/// Arguments of `merge`.
#[derive(ClapArgs)]
#[command(after_help = "\
Example:
  dapple merge shard0/ shard1/ shard2/ shard3/ -o all.jsonl")]
pub struct Merge {
    /// Record files or folders.
    #[arg(required = true)]
    pub inputs: Vec<PathBuf>,
    /// The joined file; never overwritten unless it is among the inputs.
    #[arg(short, long)]
    pub output: PathBuf,
    /// Leave times out of the rows: a small baseline of errors and counters.
    #[arg(long)]
    pub strip_times: bool,
}

/// Arguments of `export`.
#[derive(ClapArgs)]
pub struct Export {
    /// Comma-separated values, one line a row of measurement.
    #[arg(long, required = true)]
    pub csv: bool,
    /// Record file or folder.
    #[arg(long, default_value = "records")]
    pub records: PathBuf,
    /// Problem; all if not given.
    #[arg(long)]
    pub problem: Option<String>,
    /// The file; standard output if not given.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
}

/// Arguments of the hidden `live`.
#[derive(ClapArgs)]
pub struct Live {
    /// Part of an adapter's or backend's name.
    #[arg(long)]
    pub adapter: Option<String>,
}

/// Arguments of `render`.
#[derive(ClapArgs)]
pub struct Render {
    /// Problem.
    pub problem: String,
    /// Technique or TECHNIQUE/VARIANT.
    pub technique: String,
    /// The case.
    #[command(flatten)]
    pub case: CaseArgs,
    /// Knob NAME=VALUE; repeatable.
    #[arg(long, value_name = "NAME=VALUE")]
    pub knob: Vec<String>,
    /// Form: reference, cpu or gpu.
    #[arg(long, default_value = "cpu")]
    pub form: String,
    /// Part of an adapter's or backend's name.
    #[arg(long)]
    pub adapter: Option<String>,
    /// Folder for result.png, truth.png, error.png.
    #[arg(short, long, default_value = "out")]
    pub output: PathBuf,
}

/// Arguments of `scene`.
#[derive(ClapArgs)]
pub struct Scene {
    /// What to do with a scene.
    #[command(subcommand)]
    pub verb: SceneVerb,
}

/// Verbs of `scene`.
#[derive(Subcommand)]
pub enum SceneVerb {
    /// Say what a scene needs, and what it does not.
    Inspect {
        /// File or generator name.
        scene: String,
        /// Output format.
        #[arg(long, value_enum, default_value_t)]
        format: Format,
    },
    /// Write a generated scene to a GLB file.
    Generate {
        /// Generator name; `dapple list` shows them.
        name: String,
        /// Seed.
        #[arg(long, default_value_t = 0)]
        seed: u64,
        /// The file, ending in .glb.
        #[arg(short, long)]
        output: PathBuf,
    },
}
