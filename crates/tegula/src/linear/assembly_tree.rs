//! Symbolic analysis for the multifrontal method: fronts, what they hold, and the tree in which they are assembled.
//!
//! J. W. H. Liu, *The multifrontal method for sparse matrix solution*, SIAM Review 34 (1992) 82–109. Columns of
//! equal structure are one front; small fronts are joined with their parents where that adds few zeros.

use super::FactorError;
use super::ordering::Quotient;
use super::trapezoid::Trapezoid;

/// Zeros that joining a front with its parent may add, as a share of the joined front, by its number of columns.
const MOST_ZEROS: [(usize, f64); 3] = [(24, 0.8), (64, 0.15), (usize::MAX, 0.04)];

/// A front: a dense symmetric matrix of columns that are eliminated in it and of rows that it passes on.
#[derive(Debug, Clone, Default)]
pub(super) struct Front {
    /// First of the columns that are eliminated in it, in the order of elimination.
    pub first: usize,
    /// Number of columns.
    pub width: usize,
    /// Rows below them: numbers of later columns, ascending.
    pub rows: Vec<u32>,
    /// The front that takes what is passed on; none: nothing is.
    pub parent: Option<u32>,
    /// Where the rows lie in the parent: runs (first row here, first place there, length). Places count the parent's
    /// columns first, then its rows.
    pub runs: Vec<[u32; 3]>,
    /// First front of its subtree; the fronts of a subtree are numbered one after another, itself last.
    pub leaf: usize,
    /// Where its panel begins in the factor.
    pub panel: usize,
    /// Where its rows begin in vectors of all rows.
    pub row_start: usize,
    /// First of its runs of entries of the matrix.
    pub entries: usize,
    /// Operations of its subtree.
    pub work: f64,
}

impl Front {
    /// Order of the dense matrix.
    pub fn height(&self) -> usize {
        self.width + self.rows.len()
    }

    /// Its columns, as they are stored in the factor.
    pub fn layout(&self) -> Trapezoid {
        Trapezoid { rows: self.height(), columns: self.width }
    }

    /// What it passes on.
    pub fn passed(&self) -> Trapezoid {
        Trapezoid::triangle(self.rows.len())
    }
}

/// Entries that follow one another in the matrix and stand at equal distances in a panel.
#[derive(Debug, Clone, Copy)]
struct EntryRun {
    /// Number of the first value.
    value: u32,
    /// Its place in the panel.
    at: u32,
    /// Distance of the places, times 256, plus the number of entries.
    step_and_length: u32,
}

impl EntryRun {
    fn length(self) -> u32 {
        self.step_and_length & 255
    }

    /// Whether the entry with the next value belongs to the run, which then holds it.
    fn take(&mut self, at: u32) -> bool {
        let length = self.length();
        let step = if length == 1 { at.wrapping_sub(self.at) } else { self.step_and_length >> 8 };
        let fits = length < 255
            && step < 1 << 24
            && at == self.at.wrapping_add(step.wrapping_mul(length))
            && at > self.at;
        if fits {
            self.step_and_length = (step << 8) | (length + 1);
        }
        fits
    }
}

/// Fronts in the order of elimination, and where the entries of the matrix go.
#[derive(Debug, Default)]
pub(super) struct AssemblyTree {
    pub fronts: Vec<Front>,
    /// Children of each front, ascending.
    pub children: Vec<Vec<u32>>,
    /// Unknown eliminated at each place.
    pub order: Vec<u32>,
    /// Entries of the matrix by front.
    entries: Vec<EntryRun>,
    /// Entries of the factor.
    pub size: usize,
    /// Rows of all fronts together.
    pub rows: usize,
}

impl AssemblyTree {
    /// Analyses a lower triangle in compressed columns for an order of its groups.
    ///
    /// # Errors
    /// The factor is too large to be indexed.
    pub fn new(
        quotient: &Quotient,
        order: &[u32],
        pointers: &[usize],
        rows: &[u32],
    ) -> Result<Self, FactorError> {
        let mut fronts = join(fundamental_fronts(quotient, order));
        sort_for_little_memory(&mut fronts);
        Self::number(quotient, fronts, pointers, rows)
    }

    /// Operations of a factorisation.
    pub fn operations(&self) -> f64 {
        self.fronts.iter().filter(|f| f.parent.is_none()).map(|f| f.work).sum()
    }

    /// Entries that the children of a front pass on.
    pub fn passed_by_children(&self, f: usize) -> usize {
        self.children[f].iter().map(|&c| self.fronts[c as usize].passed().size()).sum()
    }

    /// Adds the entries of the matrix to the panel of a front.
    pub fn enter(&self, f: usize, values: &[f64], panel: &mut [f64]) {
        let end = self.fronts.get(f + 1).map_or(self.entries.len(), |next| next.entries);
        for run in &self.entries[self.fronts[f].entries..end] {
            let (step, mut at) = ((run.step_and_length >> 8) as usize, run.at as usize);
            for value in &values[run.value as usize..][..run.length() as usize] {
                panel[at] += value;
                at += step;
            }
        }
    }

    /// Calls `f` with the number of each value of the matrix, its row and its column; which is which does not matter.
    pub fn each_entry(&self, mut f: impl FnMut(usize, usize, usize)) {
        for (number, front) in self.fronts.iter().enumerate() {
            let layout = front.layout();
            let end = self.fronts.get(number + 1).map_or(self.entries.len(), |next| next.entries);
            for run in &self.entries[front.entries..end] {
                for k in 0..run.length() {
                    let at = run.at + k * (run.step_and_length >> 8);
                    let (row, column) = layout.place(at as usize);
                    let unknown = |local: usize| {
                        let below = local.checked_sub(front.width);
                        let place = below.map_or(front.first + local, |b| front.rows[b] as usize);
                        self.order[place] as usize
                    };
                    f((run.value + k) as usize, unknown(row), unknown(column));
                }
            }
        }
    }

    /// Numbers the columns in the order of the fronts, and finds where everything goes.
    pub fn number(
        quotient: &Quotient,
        drafts: Vec<Draft>,
        pointers: &[usize],
        rows: &[u32],
    ) -> Result<Self, FactorError> {
        let n = pointers.len() - 1;
        let mut tree = Self { order: Vec::with_capacity(n), ..Self::default() };
        // Columns of the groups, in the order of the fronts.
        let mut first_column = vec![0_u32; quotient.len()];
        for draft in &drafts {
            for &g in &draft.columns {
                first_column[g as usize] = tree.order.len() as u32;
                tree.order.extend_from_slice(&quotient.members[g as usize]);
            }
        }
        let mut place = vec![0_u32; n];
        let mut front_of = vec![0_u32; n];
        for (new, &old) in tree.order.iter().enumerate() {
            place[old as usize] = new as u32;
        }
        let mut first = 0;
        for (f, draft) in drafts.iter().enumerate() {
            let width: usize = draft.columns.iter().map(|&g| quotient.members[g as usize].len()).sum();
            front_of[first..first + width].fill(f as u32);
            let mut below: Vec<u32> = Vec::new();
            for &g in &draft.rows {
                let start = first_column[g as usize];
                below.extend(start..start + quotient.members[g as usize].len() as u32);
            }
            below.sort_unstable();
            tree.fronts.push(Front { first, width, rows: below, parent: draft.parent, ..Front::default() });
            first += width;
        }
        tree.children = vec![Vec::new(); tree.fronts.len()];
        for f in 0..tree.fronts.len() {
            if let Some(p) = tree.fronts[f].parent {
                tree.children[p as usize].push(f as u32);
                tree.fronts[f].runs = runs(&tree.fronts[f].rows, &tree.fronts[p as usize]);
            }
        }
        for f in 0..tree.fronts.len() {
            let below: f64 = tree.children[f].iter().map(|&c| tree.fronts[c as usize].work).sum();
            let leaf = tree.children[f].first().map_or(f, |&c| tree.fronts[c as usize].leaf);
            let front = &mut tree.fronts[f];
            let (w, m) = (front.width as f64, front.rows.len() as f64);
            front.work = below + w * w * w / 3.0 + w * w * m + w * m * m;
            front.leaf = leaf;
            (front.panel, front.row_start) = (tree.size, tree.rows);
            let rectangle = front.height().checked_mul(front.height());
            if rectangle.is_none_or(|s| s > isize::MAX as usize / 8) {
                return Err(FactorError::TooLarge);
            }
            tree.size = front
                .layout()
                .size()
                .checked_add(tree.size)
                .filter(|s| *s < isize::MAX as usize / 8)
                .ok_or(FactorError::TooLarge)?;
            tree.rows += front.rows.len();
        }
        tree.place_entries(&place, &front_of, pointers, rows)?;
        Ok(tree)
    }

    /// Where each entry of the matrix goes.
    fn place_entries(
        &mut self,
        place: &[u32],
        front_of: &[u32],
        pointers: &[usize],
        rows: &[u32],
    ) -> Result<(), FactorError> {
        let mut count = vec![0_usize; self.fronts.len() + 1];
        self.each_run(place, front_of, pointers, rows, |f, _| count[f + 1] += 1)?;
        for f in 0..self.fronts.len() {
            count[f + 1] += count[f];
        }
        let none = EntryRun { value: 0, at: 0, step_and_length: 0 };
        let mut entries = vec![none; count[self.fronts.len()]];
        let mut next = count.clone();
        self.each_run(place, front_of, pointers, rows, |f, run| {
            entries[next[f]] = run;
            next[f] += 1;
        })?;
        self.entries = entries;
        for (front, first) in self.fronts.iter_mut().zip(count) {
            front.entries = first;
        }
        Ok(())
    }

    /// Calls `take` with the front of each run of entries.
    fn each_run(
        &self,
        place: &[u32],
        front_of: &[u32],
        pointers: &[usize],
        rows: &[u32],
        mut take: impl FnMut(usize, EntryRun),
    ) -> Result<(), FactorError> {
        for j in 0..place.len() {
            let mut run: Option<(usize, EntryRun)> = None;
            let mut below = 0;
            for k in pointers[j]..pointers[j + 1] {
                let (a, b) = (place[rows[k] as usize], place[j]);
                let (column, row) = (a.min(b) as usize, a.max(b));
                let f = front_of[column] as usize;
                let front = &self.fronts[f];
                let column = column - front.first;
                let local = if (row as usize) < front.first + front.width {
                    row as usize - front.first
                } else {
                    // Mostly the one after the last.
                    if front.rows.get(below) != Some(&row) {
                        below = front.rows.binary_search(&row).map_err(|_| FactorError::TooLarge)?;
                    }
                    below += 1;
                    front.width + below - 1
                };
                let at = u32::try_from(front.layout().diagonal(column) + local - column)
                    .map_err(|_| FactorError::TooLarge)?;
                if let Some((of, run)) = &mut run
                    && *of == f
                    && run.take(at)
                {
                    continue;
                }
                let value = u32::try_from(k).map_err(|_| FactorError::TooLarge)?;
                if let Some((f, done)) = run.replace((f, EntryRun { value, at, step_and_length: 1 })) {
                    take(f, done);
                }
            }
            if let Some((f, done)) = run {
                take(f, done);
            }
        }
        Ok(())
    }
}

/// Runs of consecutive rows that are consecutive in the parent, too.
fn runs(rows: &[u32], parent: &Front) -> Vec<[u32; 3]> {
    let end = (parent.first + parent.width) as u32;
    let mut out: Vec<[u32; 3]> = Vec::new();
    let mut below = 0;
    for (here, &row) in (0_u32..).zip(rows) {
        let there = if row < end {
            row - parent.first as u32
        } else {
            while parent.rows[below] != row {
                below += 1;
            }
            (parent.width + below) as u32
        };
        // A run lies in the columns or in the rows, not in both.
        match out.last_mut() {
            Some([_, at, length]) if *at + *length == there && there != parent.width as u32 => *length += 1,
            _ => out.push([here, there, 1]),
        }
    }
    out
}

/// A front in terms of groups.
#[derive(Debug, Clone, Default)]
pub(super) struct Draft {
    pub columns: Vec<u32>,
    pub rows: Vec<u32>,
    pub parent: Option<u32>,
    /// Number of unknowns in columns and rows.
    pub width: usize,
    pub below: usize,
    /// Entries of the trapezoid that are zero.
    pub zeros: f64,
}

fn trapezoid(width: usize, below: usize) -> f64 {
    let (w, m) = (width as f64, below as f64);
    w * (w + 1.0) / 2.0 + w * m
}

/// Fronts of columns of equal structure, children before parents.
fn fundamental_fronts(quotient: &Quotient, order: &[u32]) -> Vec<Draft> {
    let n = quotient.len();
    const NONE: u32 = u32::MAX;
    let mut position = vec![0_u32; n];
    for (k, &g) in order.iter().enumerate() {
        position[g as usize] = k as u32;
    }
    // Elimination tree by paths that are shortened as they are walked.
    let (mut parent, mut ancestor) = (vec![NONE; n], vec![NONE; n]);
    for (i, &g) in order.iter().enumerate() {
        for &h in &quotient.neighbours[g as usize] {
            let mut r = position[h as usize];
            if r as usize >= i {
                continue;
            }
            loop {
                let next = ancestor[r as usize];
                if next == i as u32 {
                    break;
                }
                ancestor[r as usize] = i as u32;
                if next == NONE {
                    parent[r as usize] = i as u32;
                    break;
                }
                r = next;
            }
        }
    }
    let postorder = postorder(&parent);
    let mut rank = vec![0_u32; n];
    for (k, &node) in postorder.iter().enumerate() {
        rank[node as usize] = k as u32;
    }
    let weight = |g: u32| quotient.members[g as usize].len();
    let mut mark = vec![NONE; n];
    let mut structure: Vec<Vec<u32>> = vec![Vec::new(); n];
    let mut children: Vec<Vec<u32>> = vec![Vec::new(); n];
    let mut fronts: Vec<Draft> = Vec::new();
    // The front of each node, and the node it began with.
    let mut front_of = vec![0_u32; n];
    for (k, &node) in postorder.iter().enumerate() {
        let g = order[node as usize];
        let mut rows = Vec::new();
        mark[g as usize] = k as u32;
        let later = quotient.neighbours[g as usize].iter().copied().filter(|&h| position[h as usize] > node);
        for h in later.chain(children[k].iter().flat_map(|&c| structure[c as usize].iter().copied())) {
            if mark[h as usize] != k as u32 {
                mark[h as usize] = k as u32;
                rows.push(h);
            }
        }
        let only = children[k].last().copied();
        let below: usize = rows.iter().map(|&h| weight(h)).sum();
        for &c in &children[k] {
            structure[c as usize] = Vec::new();
        }
        let same = only.filter(|&c| {
            c as usize + 1 == k && fronts[front_of[c as usize] as usize].below == below + weight(g)
        });
        let front = if let Some(c) = same {
            let f = front_of[c as usize];
            fronts[f as usize].columns.push(g);
            f
        } else {
            fronts.push(Draft { columns: vec![g], ..Draft::default() });
            fronts.len() as u32 - 1
        };
        front_of[k] = front;
        let draft = &mut fronts[front as usize];
        draft.width += weight(g);
        draft.below = below;
        draft.rows.clone_from(&rows);
        structure[k] = rows;
        if parent[node as usize] != NONE {
            children[rank[parent[node as usize] as usize] as usize].push(k as u32);
        }
    }
    for (k, &node) in postorder.iter().enumerate() {
        let p = parent[node as usize];
        if p != NONE {
            let up = front_of[rank[p as usize] as usize];
            if up != front_of[k] {
                fronts[front_of[k] as usize].parent = Some(up);
            }
        }
    }
    fronts
}

/// Nodes of a forest, children before parents.
fn postorder(parent: &[u32]) -> Vec<u32> {
    const NONE: u32 = u32::MAX;
    let n = parent.len();
    let (mut first, mut next) = (vec![NONE; n], vec![NONE; n]);
    let mut roots = Vec::new();
    for v in (0..n).rev() {
        match parent[v] {
            NONE => roots.push(v as u32),
            p => {
                next[v] = first[p as usize];
                first[p as usize] = v as u32;
            }
        }
    }
    let mut out = Vec::with_capacity(n);
    let mut stack = Vec::new();
    for root in roots.into_iter().rev() {
        stack.push(root);
        while let Some(&v) = stack.last() {
            let child = first[v as usize];
            if child == NONE {
                out.push(v);
                stack.pop();
            } else {
                first[v as usize] = next[child as usize];
                stack.push(child);
            }
        }
    }
    out
}

/// Joins fronts with their parents where that adds few zeros.
fn join(mut fronts: Vec<Draft>) -> Vec<Draft> {
    let n = fronts.len();
    let mut children: Vec<Vec<u32>> = vec![Vec::new(); n];
    for (f, front) in fronts.iter().enumerate() {
        if let Some(p) = front.parent {
            children[p as usize].push(f as u32);
        }
    }
    let mut gone = vec![false; n];
    for p in 0..n {
        // The child with the largest structure first: it adds the fewest zeros.
        loop {
            let parent = &fronts[p];
            let joined = |c: u32| {
                let child = &fronts[c as usize];
                let all = trapezoid(child.width + parent.width, parent.below);
                let zeros = all - trapezoid(child.width, child.below) - trapezoid(parent.width, parent.below)
                    + child.zeros
                    + parent.zeros;
                (zeros, zeros / all)
            };
            let best = children[p].iter().copied().min_by(|&a, &b| joined(a).1.total_cmp(&joined(b).1));
            let Some(c) = best else { break };
            let (zeros, share) = joined(c);
            let width = fronts[c as usize].width + parent.width;
            let allowed = MOST_ZEROS.iter().find(|(w, _)| width <= *w).map_or(0.0, |z| z.1);
            if share > allowed {
                break;
            }
            let child = std::mem::take(&mut fronts[c as usize]);
            gone[c as usize] = true;
            let parent = &mut fronts[p];
            parent.width = width;
            parent.zeros = zeros;
            let mut columns = child.columns;
            columns.append(&mut parent.columns);
            parent.columns = columns;
            children[p].retain(|&x| x != c);
            let grandchildren = std::mem::take(&mut children[c as usize]);
            for &x in &grandchildren {
                fronts[x as usize].parent = Some(p as u32);
            }
            children[p].extend(grandchildren);
        }
    }
    keep(fronts, &gone)
}

/// The fronts that are not gone. None of them has a parent that is.
pub(super) fn keep(fronts: Vec<Draft>, gone: &[bool]) -> Vec<Draft> {
    let mut number = vec![0_u32; fronts.len()];
    let mut kept = 0;
    for (number, gone) in number.iter_mut().zip(gone) {
        *number = kept;
        kept += u32::from(!gone);
    }
    let mut out: Vec<Draft> = fronts.into_iter().zip(gone).filter(|(_, g)| !**g).map(|(f, _)| f).collect();
    for f in &mut out {
        f.parent = f.parent.map(|p| number[p as usize]);
    }
    out
}

/// Orders the fronts depth first, so that subtrees stand together and the parts that wait are small: children by
/// what they need at their worst less what they leave.
pub(super) fn sort_for_little_memory(fronts: &mut Vec<Draft>) {
    let n = fronts.len();
    let mut children: Vec<Vec<u32>> = vec![Vec::new(); n];
    let mut roots = Vec::new();
    for (f, front) in fronts.iter().enumerate() {
        match front.parent {
            Some(p) => children[p as usize].push(f as u32),
            None => roots.push(f as u32),
        }
    }
    let left = |f: u32| (fronts[f as usize].below as f64).powi(2);
    let mut peak = vec![0.0_f64; n];
    for f in 0..n {
        let mut mine = std::mem::take(&mut children[f]);
        mine.sort_by(|&a, &b| (peak[b as usize] - left(b)).total_cmp(&(peak[a as usize] - left(a))));
        let mut held = 0.0;
        for &c in &mine {
            peak[f] = peak[f].max(held + peak[c as usize]);
            held += left(c);
        }
        peak[f] = peak[f].max(held + left(f as u32));
        children[f] = mine;
    }
    let mut out = Vec::with_capacity(n);
    let mut number = vec![0_u32; n];
    let mut stack: Vec<(u32, usize)> = Vec::new();
    for root in roots {
        stack.push((root, 0));
        while let Some((f, next)) = stack.pop() {
            if let Some(&c) = children[f as usize].get(next) {
                stack.push((f, next + 1));
                stack.push((c, 0));
            } else {
                number[f as usize] = out.len() as u32;
                out.push(std::mem::take(&mut fronts[f as usize]));
            }
        }
    }
    for f in &mut out {
        f.parent = f.parent.map(|p| number[p as usize]);
    }
    *fronts = out;
}
