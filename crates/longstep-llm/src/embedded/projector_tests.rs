//! Headers of projectors, and the reasons why they are refused.

use std::collections::HashMap;

use super::gguf::{Header, Tensor, Value, read};
use super::projector::{Facts, facts};

/// The header of a projector of the kind `mlp`: embeddings of 8 numbers, one layer, pictures of 4 by 4 patches.
fn header() -> Header {
    let number = |key: &str, value: u32| (format!("clip.vision.{key}"), Value::U32(value));
    let mut values = HashMap::from([
        ("general.architecture".into(), Value::Text("clip".into())),
        ("clip.projector_type".into(), Value::Text("mlp".into())),
        ("clip.has_vision_encoder".into(), Value::Bool(true)),
        ("clip.vision.attention.layer_norm_epsilon".into(), Value::F32(1e-5)),
        number("embedding_length", 8),
        number("attention.head_count", 2),
        number("feed_forward_length", 16),
        number("block_count", 1),
        number("projection_dim", 12),
        number("image_size", 8),
        number("patch_size", 2),
    ]);
    for key in ["image_mean", "image_std"] {
        values.insert(format!("clip.vision.{key}"), Value::F32List(vec![0.5; 3]));
    }
    let mut tensors = HashMap::new();
    let mut add = |name: &str, shape: [u64; 4]| tensors.insert(name.to_owned(), Tensor { shape, is_f32: true });
    add("v.patch_embd.weight", [2, 2, 3, 8]);
    add("v.position_embd.weight", [8, 16, 1, 1]);
    for norm in ["ln1", "ln2"] {
        add(&format!("v.blk.0.{norm}.weight"), [8, 1, 1, 1]);
    }
    for part in ["attn_q", "attn_k", "attn_v", "attn_out"] {
        add(&format!("v.blk.0.{part}.weight"), [8, 8, 1, 1]);
        add(&format!("v.blk.0.{part}.bias"), [8, 1, 1, 1]);
    }
    add("v.blk.0.ffn_up.weight", [8, 16, 1, 1]);
    add("v.blk.0.ffn_down.weight", [16, 8, 1, 1]);
    for (name, input) in [("mm.0", 8), ("mm.2", 12)] {
        add(&format!("{name}.weight"), [input, 12, 1, 1]);
        add(&format!("{name}.bias"), [12, 1, 1, 1]);
    }
    Header { values, tensors }
}

#[test]
fn numbers_of_the_metadata_are_checked() {
    assert_eq!(facts(&header()), Ok(Facts { width: Some(12) }));
    let text = |text: &str| Some(Value::Text(text.into()));
    for (key, value, reason) in [
        (
            "general.architecture",
            text("qwen2"),
            "of the architecture `qwen2` and no projector",
        ),
        ("general.architecture", None, "does not say its architecture"),
        ("clip.has_vision_encoder", Some(Value::Bool(false)), "no vision encoder"),
        ("clip.projector_type", None, "does not say its kind"),
        ("clip.projector_type", text("deepseek4v"), "do not work here"),
        ("clip.vision.patch_size", Some(Value::U32(0)), "is 0, not 1 to 1024"),
        (
            "clip.vision.patch_size",
            Some(Value::U32(9)),
            "larger than its pictures of 8",
        ),
        (
            "clip.vision.patch_size",
            Some(Value::I32(2)),
            "not a number of the right kind",
        ),
        ("clip.vision.image_size", Some(Value::U32(1_000_000)), "not 1 to 16384"),
        ("clip.vision.image_size", None, "no number `clip.vision.image_size`"),
        (
            "clip.vision.image_size",
            Some(Value::U32(80)),
            "16 places for 1600 patches",
        ),
        (
            "clip.vision.attention.head_count",
            Some(Value::U32(3)),
            "3 heads cannot share",
        ),
        ("clip.vision.attention.head_count", Some(Value::U32(0)), "is 0, not 1"),
        (
            "clip.vision.block_count",
            Some(Value::U32(2)),
            "no tensor `v.blk.1.ln1.weight`",
        ),
        (
            "clip.vision.image_std",
            Some(Value::F32List(vec![0.5])),
            "list of three numbers",
        ),
        ("clip.use_gelu", Some(Value::U32(1)), "not a truth value"),
        ("clip.vision.projector.scale_factor", Some(Value::U32(0)), "not 1 to 64"),
        (
            "clip.vision.attention.layer_norm_epsilon",
            Some(Value::F32(f32::NAN)),
            "not a number",
        ),
    ] {
        let mut header = header();
        match value {
            Some(value) => header.values.insert(key.to_owned(), value),
            None => header.values.remove(key),
        };
        let error = facts(&header).unwrap_err();
        assert!(error.contains(reason), "{key}: {error}");
    }
    // Kinds that are not in the table are left to llama.cpp.
    let mut other = header();
    other
        .values
        .insert("clip.projector_type".into(), Value::Text("pixtral".into()));
    other.tensors.clear();
    assert_eq!(facts(&other), Ok(Facts { width: None }));
}

#[test]
fn shapes_of_the_tensors_have_to_fit() {
    for (name, shape, reason) in [
        ("v.patch_embd.weight", Some([2, 2, 1, 8]), "has the shape [2, 2, 1, 8]"),
        ("v.position_embd.weight", None, "no tensor `v.position_embd.weight`"),
        ("v.position_embd.weight", Some([9, 16, 1, 1]), "9 numbers"),
        ("v.blk.0.attn_k.weight", None, "no tensor `v.blk.0.attn_k.weight`"),
        (
            "v.blk.0.attn_k.weight",
            Some([8, 9, 1, 1]),
            "has the shape [8, 9, 1, 1]",
        ),
        (
            "v.blk.0.attn_k.bias",
            Some([9, 1, 1, 1]),
            "its numbers say [8, 1, 1, 1]",
        ),
        (
            "v.blk.0.attn_qkv.weight",
            Some([8, 24, 1, 1]),
            "does not belong to its kind",
        ),
        (
            "v.blk.0.ffn_down.weight",
            Some([15, 8, 1, 1]),
            "has the shape [15, 8, 1, 1]",
        ),
        ("v.post_ln.weight", Some([7, 1, 1, 1]), "has the shape [7, 1, 1, 1]"),
        ("mm.0.bias", None, "no tensor `mm.0.bias`"),
        ("mm.2.weight", Some([8, 12, 1, 1]), "has the shape [8, 12, 1, 1]"),
    ] {
        let mut header = header();
        match shape {
            Some(shape) => header.tensors.insert(name.to_owned(), Tensor { shape, is_f32: true }),
            None => header.tensors.remove(name),
        };
        let error = facts(&header).unwrap_err();
        assert!(error.contains(reason), "{name}: {error}");
    }
    let mut header = header();
    let shape = [8, 1, 1, 1];
    header
        .tensors
        .insert("v.blk.0.ln1.weight".into(), Tensor { shape, is_f32: false });
    assert!(facts(&header).unwrap_err().contains("number format"));
}

#[test]
fn gguf_header_is_read_only_from_complete_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.gguf");
    let mut whole = b"GGUF".to_vec();
    whole.extend(3_u32.to_le_bytes());
    whole.extend([1_u64, 2].map(u64::to_le_bytes).concat());
    let text = |text: &str| [&(text.len() as u64).to_le_bytes(), text.as_bytes()].concat();
    whole.extend(
        [
            text("number"),
            4_u32.to_le_bytes().to_vec(),
            7_u32.to_le_bytes().to_vec(),
        ]
        .concat(),
    );
    whole.extend([text("list"), [9_u32, 8].map(u32::to_le_bytes).concat()].concat());
    whole.extend([1_u64.to_le_bytes().to_vec(), text("one")].concat());
    whole.extend(
        [
            text("tensor"),
            1_u32.to_le_bytes().to_vec(),
            3_u64.to_le_bytes().to_vec(),
        ]
        .concat(),
    );
    whole.extend([0_u32.to_le_bytes().to_vec(), 0_u64.to_le_bytes().to_vec()].concat());
    whole.resize(whole.len().next_multiple_of(32), 0);
    whole.extend([0; 12]);
    std::fs::write(&path, &whole).unwrap();
    let header = read(&path).unwrap();
    assert_eq!(header.values["number"], Value::U32(7));
    assert_eq!(header.values["list"], Value::Other);
    assert_eq!(header.tensors["tensor"].shape, [3, 1, 1, 1]);
    for length in 0..whole.len() {
        std::fs::write(&path, &whole[..length]).unwrap();
        read(&path).unwrap_err();
    }
    for place in 0..whole.len() {
        for byte in [0, 1, 0x7f, 0xff] {
            let mut bytes = whole.clone();
            bytes[place] = byte;
            std::fs::write(&path, bytes).unwrap();
            let _ = read(&path);
        }
    }
}
