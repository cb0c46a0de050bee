//! `--eds`: what the data sheets of drives and load cells lack of what the bridge asks of them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use cable_robot_fieldbus::Config;
use cable_robot_fieldbus::bridge::needs;
use cable_robot_fieldbus::canopen::Node;
use cable_robot_fieldbus::canopen::eds::{DataSheet, Lack};
use cable_robot_files::LONGEST_TEXT;

/// A data sheet, and the nodes that it is of.
#[derive(Clone, Debug)]
pub struct SheetOf {
    nodes: Nodes,
    path: PathBuf,
}

#[derive(Clone, Copy, Debug)]
enum Nodes {
    Drives,
    LoadCells,
    One(Node),
}

/// `drives=FILE`, `load-cells=FILE` or the address of a node, `3=FILE`.
pub fn sheet_of(text: &str) -> Result<SheetOf, String> {
    let expected = "expected like drives=akd.eds, load-cells=cell.eds or 3=akd.eds";
    let (nodes, path) = text.split_once('=').ok_or(expected)?;
    let nodes = match nodes {
        "drives" => Nodes::Drives,
        "load-cells" => Nodes::LoadCells,
        node => Nodes::One(node.parse().map_err(|_| expected)?),
    };
    Ok(SheetOf { nodes, path: path.into() })
}

/// What `--check` says of the sheets, and how many lack something.
pub fn text(config: &Config, sheets: &[SheetOf]) -> Result<(String, usize)> {
    let (mut text, mut lacking) = (String::new(), 0);
    for SheetOf { nodes, path } in sheets {
        let sheet = read(path)?;
        let nodes = nodes.of(config);
        ensure!(!nodes.is_empty(), "--eds {}: the fieldbus file has no such node", path.display());
        let (mut lacks, mut of) = (Vec::<Lack>::new(), vec![]);
        for (bus, node) in nodes {
            let found = sheet.lacks(&needs(config, (bus, node)));
            lacks.extend(found.into_iter().filter(|lack| !lacks.contains(lack)).collect::<Vec<_>>());
            of.push(node.to_string());
        }
        let what =
            if lacks.is_empty() { "has all that the bridge uses" } else { "lacks what the bridge uses:" };
        text += &format!("\n{} ({}), of node {}, {what}\n", path.display(), sheet.product, of.join(", "));
        lacks.iter().for_each(|lack| text += &format!("  {lack}\n"));
        lacking += usize::from(!lacks.is_empty());
    }
    Ok((text, lacking))
}

fn read(path: &Path) -> Result<DataSheet> {
    let text = cable_robot_files::read(path, LONGEST_TEXT)
        .with_context(|| format!("cannot read {}", path.display()))?;
    // Many sheets are not in UTF-8; only names can suffer.
    let text = String::from_utf8_lossy(&text);
    match DataSheet::parse(&text) {
        Ok(sheet) => Ok(sheet),
        Err(error) => bail!("{}: {error}", path.display()),
    }
}

impl Nodes {
    /// With their buses, in their order.
    fn of(self, config: &Config) -> BTreeSet<(usize, Node)> {
        let drives = config.drives.iter().map(|drive| (drive.bus, drive.node));
        let cells = config.load_cells.iter().map(|cell| (cell.bus, cell.node));
        match self {
            Self::Drives => drives.collect(),
            Self::LoadCells => cells.collect(),
            Self::One(node) => drives.chain(cells).filter(|(_, other)| *other == node).collect(),
        }
    }
}
