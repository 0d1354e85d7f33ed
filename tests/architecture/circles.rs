//! Strongly connected components of a directed graph, by R. Tarjan, SIAM Journal on Computing 1 (1972).

/// The nodes of each component of two nodes or more; `arrows[i]` are the nodes that node i points at.
pub fn circles(arrows: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let mut search = Search {
        arrows,
        order: vec![None; arrows.len()],
        lowest: vec![0; arrows.len()],
        stack: Vec::new(),
        visited: 0,
        circles: Vec::new(),
    };
    for node in 0..arrows.len() {
        if search.order[node].is_none() {
            search.visit(node);
        }
    }
    search.circles
}

struct Search<'a> {
    arrows: &'a [Vec<usize>],
    order: Vec<Option<usize>>,
    /// The earliest node on the stack that a node reaches.
    lowest: Vec<usize>,
    stack: Vec<usize>,
    visited: usize,
    circles: Vec<Vec<usize>>,
}

impl Search<'_> {
    fn visit(&mut self, node: usize) {
        let order = self.visited;
        self.visited += 1;
        self.order[node] = Some(order);
        self.lowest[node] = order;
        self.stack.push(node);
        for &next in &self.arrows[node] {
            match self.order[next] {
                None => {
                    self.visit(next);
                    self.lowest[node] = self.lowest[node].min(self.lowest[next]);
                }
                Some(earlier) if self.stack.contains(&next) => {
                    self.lowest[node] = self.lowest[node].min(earlier);
                }
                Some(_) => {}
            }
        }
        if self.lowest[node] == order {
            let bottom = self.stack.iter().position(|n| *n == node).unwrap();
            let mut component = self.stack.split_off(bottom);
            if component.len() > 1 {
                component.sort_unstable();
                self.circles.push(component);
            }
        }
    }
}

#[test]
fn finds_each_component_once() {
    // 0 → 1 → 2 → 0, and 2 → 3 → 4 → 3; 5 points at itself only.
    let arrows = [vec![1], vec![2], vec![0, 3], vec![4], vec![3], vec![5]];
    let mut found = circles(&arrows);
    found.sort();
    assert_eq!(found, [vec![0, 1, 2], vec![3, 4]]);
    assert_eq!(
        circles(&[vec![1, 2], vec![2], vec![]]),
        Vec::<Vec<usize>>::new()
    );
}
