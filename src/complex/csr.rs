//! Lists of ids, one a row, stored end to end.

/// A table from rows to the items of each row, in the order in which they were given.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Csr {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Csr {
    /// Sorts `pairs` of (row, item) into `rows` rows, in linear time. Rows beyond the last are left
    /// out.
    pub(super) fn new(rows: usize, pairs: impl Iterator<Item = (u32, u32)> + Clone) -> Self {
        let pairs = pairs.filter(|&(row, _)| (row as usize) < rows);
        let mut starts = vec![0u32; rows + 1];
        for (row, _) in pairs.clone() {
            starts[row as usize + 1] += 1;
        }
        for row in 0..rows {
            starts[row + 1] += starts[row];
        }
        let mut items = vec![0; starts[rows] as usize];
        let mut next = starts.clone();
        for (row, item) in pairs {
            items[next[row as usize] as usize] = item;
            next[row as usize] += 1;
        }
        Csr { starts, items }
    }

    /// The items of a row; none for a row that is not there.
    pub(super) fn row(&self, row: u32) -> &[u32] {
        match self.starts.get(row as usize..row as usize + 2) {
            Some(&[start, end]) => &self.items[start as usize..end as usize],
            _ => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_keep_their_items_in_order() {
        let pairs = [(2, 7), (0, 1), (2, 5), (9, 4), (2, 6)];
        let csr = Csr::new(3, pairs.into_iter());
        let rows: Vec<&[u32]> = (0..4).map(|row| csr.row(row)).collect();
        assert_eq!(rows, [&[1][..], &[], &[7, 5, 6], &[]]);
    }
}
