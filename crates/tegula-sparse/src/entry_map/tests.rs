use std::collections::{BTreeSet, HashMap};

use super::super::assembly_tree::AssemblyTree;
use super::super::ordering::CompressedGraph;
use super::*;

/// Sparsity pattern: lower triangle in compressed columns.
struct Pattern {
    pointers: Vec<usize>,
    rows: Vec<u32>,
}

impl Pattern {
    /// Creates the pattern in which all unknowns of an element are coupled.
    fn of_elements(n: usize, elements: &[Vec<u32>]) -> Self {
        let mut columns: Vec<BTreeSet<u32>> = (0..n as u32).map(|j| BTreeSet::from([j])).collect();
        for element in elements {
            for &j in element {
                columns[j as usize].extend(element.iter().filter(|&&i| i > j));
            }
        }
        let (mut pointers, mut rows) = (vec![0], Vec::new());
        for column in columns {
            rows.extend(column);
            pointers.push(rows.len());
        }
        Self { pointers, rows }
    }

    /// Creates the pattern of square elements on a grid of nodes with consecutive unknowns; `unknowns` gives their
    /// number.
    fn grid(nx: usize, ny: usize, unknowns: impl Fn(usize) -> u32) -> Self {
        let mut first = vec![0];
        for node in 0..nx * ny {
            first.push(first[node] + unknowns(node));
        }
        let mut elements = Vec::new();
        for i in 0..nx - 1 {
            for j in 0..ny - 1 {
                let corner = i * ny + j;
                let nodes = [corner, corner + 1, corner + ny, corner + ny + 1];
                elements.push(nodes.iter().flat_map(|&node| first[node]..first[node + 1]).collect());
            }
        }
        Self::of_elements(first[nx * ny] as usize, &elements)
    }

    fn tree(&self) -> AssemblyTree {
        let graph = CompressedGraph::new(&self.pointers, &self.rows, &[]);
        let order = graph.minimum_degree();
        AssemblyTree::new(&graph, &order, &self.pointers, &self.rows).unwrap()
    }

    /// Index of each value by its row and column.
    fn numbers(&self) -> HashMap<(usize, usize), usize> {
        let column = |j: usize| (self.pointers[j]..self.pointers[j + 1]).map(move |k| (j, k));
        let all = (0..self.pointers.len() - 1).flat_map(column);
        all.map(|(j, k)| ((self.rows[k] as usize, j), k)).collect()
    }

    /// Checks that each original entry is added exactly once in a tree, in its row and column, and nothing else is.
    fn check(&self, tree: &AssemblyTree) {
        let numbers = self.numbers();
        // Value with index k; none has the value zero.
        let value = |k: usize| 1.0 + k as f64;
        let values: Vec<f64> = (0..self.rows.len()).map(value).collect();
        let mut entered = 0;
        for (f, front) in tree.fronts.iter().enumerate() {
            let layout = front.layout();
            let mut panel = vec![0.0; layout.size()];
            tree.entries.add_entries(f, &values, &mut panel);
            let own = front.first..front.first + front.width;
            let places: Vec<usize> = own.chain(front.rows.iter().map(|&row| row as usize)).collect();
            for (at, &found) in panel.iter().enumerate() {
                let (row, column) = layout.place(at);
                let (i, j) = (tree.order[places[row]] as usize, tree.order[places[column]] as usize);
                let number = numbers.get(&(i.max(j), i.min(j))).filter(|_| row >= column);
                assert_eq!(found, number.map_or(0.0, |&k| value(k)), "front {f}, row {row}, column {column}");
                entered += usize::from(number.is_some());
            }
            // All entries are collected: no value is zero.
            let mut collected = vec![0.0; tree.entries.number(f)];
            tree.entries.collect(f, &values, &mut collected);
            assert!(collected.iter().all(|v| *v != 0.0));
            let mut again = vec![0.0; layout.size()];
            tree.entries.add_collected(f, &collected, &mut again);
            assert_eq!(again, panel);
        }
        assert_eq!(entered, self.rows.len());
        let mut met = vec![0; self.rows.len()];
        tree.each_entry(|k, i, j| {
            met[k] += 1;
            assert_eq!(numbers.get(&(i.max(j), i.min(j))), Some(&k));
        });
        assert!(met.iter().all(|&times| times == 1));
    }

    /// Number of runs of one column: consecutive values of a column at equal distances in the panel of one front.
    fn runs_of_one_column(&self, tree: &AssemblyTree) -> usize {
        let mut place = vec![(0, 0); self.rows.len()];
        for f in 0..tree.fronts.len() {
            tree.entries.each(f, |k, at| place[k] = (f, at as i64));
        }
        let mut runs = 0;
        for ends in self.pointers.windows(2) {
            let mut step = None;
            for k in ends[0]..ends[1] {
                let apart = |k: usize| place[k].1 - place[k - 1].1;
                let follows = k > ends[0]
                    && place[k].0 == place[k - 1].0
                    && apart(k) > 0
                    && step.is_none_or(|s| s == apart(k));
                step = if follows { Some(apart(k)) } else { None };
                // The first entry of a run may be at any distance from the second.
                runs += usize::from(!follows);
            }
        }
        runs
    }
}

fn widest(tree: &AssemblyTree) -> usize {
    tree.fronts.iter().map(|front| front.width).max().unwrap_or(0)
}

#[test]
fn every_value_has_its_place_where_nodes_have_several_unknowns() {
    for unknowns in [2, 3, 6] {
        let pattern = Pattern::grid(7, 9, |_| unknowns);
        pattern.check(&pattern.tree());
    }
    let mixed = Pattern::grid(9, 8, |node| [6, 3, 1, 5, 6, 6, 2][node % 7]);
    mixed.check(&mixed.tree());
}

#[test]
fn every_value_has_its_place_without_groups() {
    let pattern = Pattern::grid(17, 20, |_| 1);
    let tree = pattern.tree();
    pattern.check(&tree);
    // Unknowns of a node that are not consecutive.
    let scattered: Vec<Vec<u32>> = (0..40)
        .flat_map(|i| (0..5).map(move |j| [i, i + 1].iter().map(|i| (i * 5 + j) % 205).collect()))
        .collect();
    let pattern = Pattern::of_elements(205, &scattered);
    pattern.check(&pattern.tree());
}

#[test]
fn every_value_has_its_place_beside_the_ends_of_block_columns() {
    // Columns and rows longer than a run may be, in one supervariable and in several that do not fit a block.
    let full = Pattern::of_elements(301, &[(0..301).collect()]);
    let tree = full.tree();
    assert!(widest(&tree) > 2 * BLOCK && tree.fronts.len() == 1);
    full.check(&tree);
    let groups = Pattern::of_elements(
        700,
        &[(0..350).collect(), (300..600).collect(), (0..10).chain(590..700).collect()],
    );
    let tree = groups.tree();
    assert!(widest(&tree) > BLOCK);
    groups.check(&tree);
    let fine = Pattern::grid(45, 45, |_| 6);
    let tree = fine.tree();
    assert!(widest(&tree) > BLOCK && !BLOCK.is_multiple_of(6));
    fine.check(&tree);
}

#[test]
fn every_value_has_its_place_after_columns_are_delayed() {
    let pattern = Pattern::grid(12, 12, |node| if node % 5 == 0 { 4 } else { 6 });
    let tree = pattern.tree();
    let delayed: Vec<u32> = tree
        .fronts
        .iter()
        .filter(|front| front.parent.is_some())
        .step_by(3)
        .map(|front| (front.first + front.width / 2) as u32)
        .collect();
    assert!(delayed.len() > 2);
    pattern.check(&tree.delay(&delayed, &pattern.pointers).unwrap());
}

#[test]
fn runs_hold_the_columns_of_a_node_together() {
    assert_eq!(size_of::<EntryRun>(), 16);
    let pattern = Pattern::grid(30, 30, |_| 6);
    let tree = pattern.tree();
    let (runs, single) = (tree.entries.runs.len(), pattern.runs_of_one_column(&tree));
    assert!(4 * runs <= single, "{runs} runs, {single} of one column");
    // Without supervariables there are no columns to hold together.
    let pattern = Pattern::grid(30, 30, |_| 1);
    let tree = pattern.tree();
    assert!(tree.entries.runs.len() <= pattern.runs_of_one_column(&tree));
}
