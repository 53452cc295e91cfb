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
    /// Render one technique: result, truth and error map as PNG.
    Render(Render),
    /// Inspect or generate scenes.
    Scene(Scene),
    /// One group of a run, from standard input: the runner starts this.
    #[command(hide = true)]
    RunGroup,
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
    /// Camera name; the first if not given.
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
    /// Part of an adapter's or backend's name.
    #[arg(long)]
    pub adapter: Option<String>,
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
    /// Output format.
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
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
