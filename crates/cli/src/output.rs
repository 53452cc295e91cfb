//! Tables for people, JSON lines and CSV for programs, all from the same cells.

use crate::args::Format;
use anyhow::{Context, Result};
use comfy_table::{
    CellAlignment, ColumnConstraint, ContentArrangement, Table as Comfy, Width, presets,
};
use serde_json::{Map, Value};
use std::{
    fmt,
    io::{self, Write},
};

/// A line on standard output, or the error: `println!` panics where the disk is full.
macro_rules! put {
    ($($text:tt)*) => { $crate::output::line(format_args!($($text)*)) };
}

/// A line on standard error; where nobody can read it, the work goes on.
macro_rules! note {
    ($($text:tt)*) => { $crate::output::side_line(format_args!($($text)*)) };
}

pub use dapple_records::text::significant;
pub(crate) use {note, put};

/// See [`put!`].
pub fn line(text: fmt::Arguments<'_>) -> io::Result<()> {
    writeln!(io::stdout().lock(), "{text}")
}

/// See [`note!`].
pub fn side_line(text: fmt::Arguments<'_>) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// Columns and rows; a cell is JSON so that numbers stay numbers.
pub struct Table {
    columns: Vec<&'static str>,
    rows: Vec<Vec<Value>>,
}

impl Table {
    /// An empty table with these columns.
    pub fn new(columns: &[&'static str]) -> Self {
        Self { columns: columns.to_vec(), rows: Vec::new() }
    }

    /// Adds a row, one cell a column.
    pub fn row(&mut self, cells: impl Into<Vec<Value>>) {
        self.rows.push(cells.into());
    }

    /// Prints the table on standard output.
    pub fn print(&self, format: Format) -> Result<()> {
        let mut out = io::stdout().lock();
        match format {
            Format::Table => {
                // None unless standard output is a terminal.
                let width = Comfy::new().width();
                writeln!(out, "{}", self.comfy(width))?;
            }
            Format::Jsonl => {
                for row in &self.rows {
                    let object: Map<String, Value> =
                        self.columns.iter().map(ToString::to_string).zip(row.clone()).collect();
                    writeln!(out, "{}", Value::Object(object))?;
                }
            }
            Format::Csv => {
                let mut csv = csv::Writer::from_writer(out);
                csv.write_record(&self.columns)?;
                for row in &self.rows {
                    csv.write_record(row.iter().map(|c| plain(c, false)))?;
                }
                csv.flush().context("writing standard output")?;
            }
        }
        Ok(())
    }

    fn comfy(&self, width: Option<u16>) -> Comfy {
        let mut table = Comfy::new();
        table.load_preset(presets::NOTHING).set_header(&self.columns);
        for row in &self.rows {
            table.add_row(row.iter().map(|c| plain(c, true)));
        }
        for (i, column) in table.column_iter_mut().enumerate() {
            if self.rows.iter().any(|row| row.get(i).is_some_and(Value::is_number)) {
                column.set_cell_alignment(CellAlignment::Right);
            }
        }
        if let Some(width) = width.filter(|width| too_wide(&table, *width)) {
            table.set_content_arrangement(ContentArrangement::Dynamic).set_width(width);
            self.keep_numbers_whole(&mut table);
        }
        table
    }

    /// Where a table must wrap, only columns of words do: half a number would be misread.
    fn keep_numbers_whole(&self, table: &mut Comfy) {
        const SHORT: usize = 10;
        for (i, column) in table.column_iter_mut().enumerate() {
            column.set_padding((0, 1));
            let cells = self.rows.iter().filter_map(|row| row.get(i));
            let widest = cells.map(|c| plain(c, true).chars().count()).max().unwrap_or_default();
            if widest <= SHORT {
                let words = self.columns[i].split(' ').map(|word| word.chars().count());
                let width = words.max().unwrap_or_default().max(widest) + 1;
                column.set_constraint(ColumnConstraint::Absolute(Width::Fixed(width as u16)));
            }
        }
    }
}

fn too_wide(table: &Comfy, width: u16) -> bool {
    table.lines().any(|line| line.trim_end().chars().count() > usize::from(width))
}

/// A cell's text. For people, floats keep four significant digits.
fn plain(cell: &Value, short: bool) -> String {
    match cell {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        Value::Number(number) if short && number.is_f64() => {
            number.as_f64().map(significant).unwrap_or_default()
        }
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eighty_columns_wrap_words_and_never_numbers() {
        let columns =
            ["technique", "form", "time", "± MAD", "ratio", "error", "leak", "memory", "knobs"];
        let mut table = Table::new(&columns);
        table.row([
            "vsm/min-variance".into(),
            "cpu".into(),
            "88.95 ms".into(),
            "129.9 µs".into(),
            0.58931.into(),
            0.015434.into(),
            2.264e-8.into(),
            "12.5 MiB".into(),
            "resolution=256 taps=16 format=f16".into(),
        ]);
        let fits = |text: &str| text.lines().all(|line| line.chars().count() <= 80);
        let whole = table.comfy(None).to_string();
        assert!(!fits(&whole) && whole.lines().count() == 2, "{whole}");
        assert_eq!(table.comfy(Some(200)).to_string(), whole);
        let text = table.comfy(Some(80)).to_string();
        assert!(fits(&text), "{text}");
        for number in ["88.95 ms", "129.9 µs", "0.5893", "0.01543", "2.26e-8", "12.5 MiB"] {
            assert!(text.contains(number), "{number} in\n{text}");
        }
    }
}
