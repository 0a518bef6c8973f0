//! LZF (Marc Lehmann), the compression inside PCD files.

/// Undo LZF: exactly `size` bytes, or `None` if `data` is damaged, truncated, or gives another number of them.
///
/// Memory grows with what `data` really holds (at most 88 times its length), whatever `size` promises.
#[must_use]
pub fn lzf_decompress(data: &[u8], size: usize) -> Option<Vec<u8>> {
    let mut bytes = data.iter().copied().map(usize::from);
    let mut output = Vec::new();
    while let Some(control) = bytes.next() {
        if control < 32 {
            let literal = bytes.by_ref().take(control + 1);
            let before = output.len();
            #[allow(clippy::cast_possible_truncation)] // each was a byte
            output.extend(literal.map(|byte| byte as u8));
            if output.len() != before + control + 1 {
                return None;
            }
        } else {
            let length = match control >> 5 {
                7 => 7 + bytes.next()?,
                short => short,
            };
            let back = ((control & 31) << 8) + bytes.next()? + 1;
            let start = output.len().checked_sub(back)?;
            // One by one: a reference may reach into what it is just writing.
            for at in start..start + length + 2 {
                output.push(output[at]);
            }
        }
        if output.len() > size {
            return None;
        }
    }
    (output.len() == size).then_some(output)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::seeded;
    use proptest::prelude::*;

    #[test]
    fn literals_and_references_by_hand() {
        // Three literals, then six bytes from three back, twice as many as there are: "abc" repeats.
        assert_eq!(lzf_decompress(&[2, b'a', b'b', b'c', 4 << 5, 2], 9).unwrap(), b"abcabcabc");
        // A long reference: 7 + 3 + 2 bytes from one back.
        assert_eq!(lzf_decompress(&[0, b'x', 7 << 5, 3, 0], 13).unwrap(), [b'x'; 13]);
        assert_eq!(lzf_decompress(&[], 0).unwrap(), b"");
    }

    #[test]
    fn what_is_damaged_is_refused() {
        for (data, size) in [
            (&[2, b'a'][..], 3),             // literals are missing
            (&[0, b'x', 7 << 5], 13),        // the length is missing
            (&[0, b'x', 1 << 5], 4),         // the distance is missing
            (&[0, b'x', 1 << 5, 1], 4),      // reaches before the beginning
            (&[0, b'x', 7 << 5, 255, 0], 5), // more than promised
            (&[0, b'x'], usize::MAX),        // less than promised
        ] {
            assert_eq!(lzf_decompress(data, size), None);
        }
    }

    proptest! {
        #![proptest_config(seeded(256))]

        #[test]
        fn any_bytes_give_the_promised_size_or_nothing(data: Vec<u8>, size in 0..4096_usize) {
            if let Some(output) = lzf_decompress(&data, size) {
                prop_assert_eq!(output.len(), size);
            }
        }

        #[test]
        fn literals_read_back(text: Vec<u8>) {
            let packed: Vec<u8> = text
                .chunks(32)
                .flat_map(|chunk| [&[u8::try_from(chunk.len() - 1).unwrap()][..], chunk].concat())
                .collect();
            prop_assert_eq!(lzf_decompress(&packed, text.len()), Some(text));
        }
    }
}
