//! A part of a manifest, for one of several machines: `i/n` is every n-th item from the i-th on.

use std::str::FromStr;

/// Part `number` of `parts`, counted from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Which part, from 1.
    pub number: u64,
    /// How many parts there are.
    pub parts: u64,
}

impl Shard {
    /// Whether the item at this position, from 0, belongs to the part.
    pub fn holds(self, position: u64) -> bool {
        position % self.parts == self.number - 1
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parse = || {
            let (number, parts) = text.split_once('/')?;
            let [number, parts] = [number, parts].map(|n| n.trim().parse::<u64>().ok());
            Some(Self {
                number: number?,
                parts: parts?,
            })
        };
        parse()
            .filter(|shard| shard.number >= 1 && shard.number <= shard.parts)
            .ok_or_else(|| format!("`{text}` is no part: write i/n with 1 ≤ i ≤ n, such as 3/16"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_item_belongs_to_one_part() {
        for position in 0..20 {
            let parts = (1..=3).map(|number| Shard { number, parts: 3 });
            assert_eq!(parts.filter(|part| part.holds(position)).count(), 1);
        }
        assert_eq!(
            "2/7".parse(),
            Ok(Shard {
                number: 2,
                parts: 7
            })
        );
        for text in ["0/3", "4/3", "3", "a/b", "/"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
