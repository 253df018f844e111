//! Tables of names: what classes are called, as CSV.

use crate::encode::class;
use crate::files;
use istar::container::Names;
use istar::labels::class_color;
use std::path::Path;

/// Reads a table with two columns: a label as in 7 or a colour as in #00ff7f, and a name. A first row that has
/// neither is a heading.
pub fn read(path: &Path) -> Result<Names, String> {
    let text = files::read(path)?;
    let mut names = Names::default();
    let rows = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&text))
        .into_records();
    for (i, row) in rows.enumerate() {
        let at = |fault: &str| files::at(path, &format!("row {}: {fault}", i + 1));
        let row = row.map_err(|error| at(&error.to_string()))?;
        if row.len() < 2 {
            return Err(at("give a label or a colour, and a name: 7,Lake"));
        }
        let (key, name) = (&row[0], &row[1]);
        match color(key) {
            Some(color) => names.insert(color, name).map_err(|error| at(&error.to_string()))?,
            None if i == 0 => {}
            None => {
                return Err(at(&format!(
                    "“{key}” is neither a label, as 7, nor a colour, as #00ff7f"
                )));
            }
        }
    }
    Ok(names)
}

/// The colour that regions of a class have in the file.
fn color(key: &str) -> Option<[u8; 4]> {
    let class = class(key)?;
    Some(class_color(key.starts_with('#'), class))
}
