//! Checks a projector's file before llama.cpp loads it.
//!
//! llama.cpp's loader ends the program, rather than return an error, where numbers or tensors do not fit each other.

use std::path::Path;

use super::gguf::{self, Header, Value};

/// Reads the width of a projector, and checks its tensors.
type Projection = fn(&Encoder<'_>) -> Result<Option<u64>, String>;

/// The kinds whose tensors are checked here, because a test has one. llama.cpp knows more; the checks of those are its own.
const KINDS: [(&str, Projection); 4] = [
    ("mlp", mlp),
    ("idefics3", idefics3),
    ("gemma3", gemma3),
    ("qwen2vl_merger", qwen2vl),
];

/// Kinds that llama.cpp loads, and that do not work here, with the reason.
const REFUSED: [(&str, &str); 1] = [(
    "deepseek4v",
    "its tokens depend on the place of the picture in the whole prompt, which this engine does not tell it",
)];

/// The numbers that every projector has, with their least and greatest value. Some kinds have no layers.
const NUMBERS: [(&str, u32, u32); 7] = [
    ("clip.vision.embedding_length", 1, 65_536),
    ("clip.vision.attention.head_count", 0, 4_096),
    ("clip.vision.feed_forward_length", 0, 1_048_576),
    ("clip.vision.block_count", 0, 1_024),
    ("clip.vision.projection_dim", 0, 1_048_576),
    ("clip.vision.image_size", 1, 16_384),
    ("clip.vision.patch_size", 1, 1_024),
];

/// The numbers that some projectors have.
const OPTIONAL: [(&str, u32, u32); 10] = [
    ("clip.vision.attention.head_count_kv", 1, 4_096),
    ("clip.vision.attention.head_dim", 1, 4_096),
    ("clip.vision.image_min_pixels", 1, 100_000_000),
    ("clip.vision.image_max_pixels", 1, 100_000_000),
    ("clip.vision.preproc_min_tiles", 1, 64),
    ("clip.vision.preproc_max_tiles", 1, 256),
    ("clip.vision.preproc_image_size", 1, 65_536),
    ("clip.vision.projector.scale_factor", 1, 64),
    ("clip.vision.spatial_merge_size", 1, 16),
    ("clip.vision.n_wa_pattern", 0, 1_024),
];

/// The facts of a projector that have to fit the model.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Facts {
    /// The numbers of an embedding that it makes, where that is known before it is loaded.
    pub(super) width: Option<u64>,
}

/// Checks that a file is a complete projector for pictures.
pub(super) fn check(path: &Path) -> Result<Facts, String> {
    facts(&gguf::read(path)?)
}

pub(super) fn facts(header: &Header) -> Result<Facts, String> {
    match header.values.get("general.architecture") {
        Some(Value::Text(name)) if name == "clip" => {}
        Some(Value::Text(name)) => return Err(format!("it is a model of the architecture `{name}` and no projector")),
        _ => return Err("it does not say its architecture".into()),
    }
    if header.values.get("clip.has_vision_encoder") != Some(&Value::Bool(true)) {
        return Err("it has no vision encoder".into());
    }
    for (key, least, most) in NUMBERS {
        number(header, key, least, most)?.ok_or_else(|| format!("it has no number `{key}`"))?;
    }
    for (key, least, most) in OPTIONAL {
        number(header, key, least, most)?;
    }
    for key in ["clip.use_gelu", "clip.use_silu"] {
        if !matches!(header.values.get(key), None | Some(Value::Bool(_))) {
            return Err(format!("its `{key}` is not a truth value"));
        }
    }
    let epsilon = header.values.get("clip.vision.attention.layer_norm_epsilon");
    if !matches!(epsilon, Some(Value::F32(own)) if own.is_finite() && *own >= 0.0) {
        return Err("its `clip.vision.attention.layer_norm_epsilon` is not a number".into());
    }
    for key in ["clip.vision.image_mean", "clip.vision.image_std"] {
        if !matches!(header.values.get(key), Some(Value::F32List(list)) if list.len() >= 3) {
            return Err(format!("its `{key}` is not a list of three numbers"));
        }
    }
    let named = ["clip.projector_type", "clip.vision.projector_type"].map(|key| header.values.get(key));
    let Some(Value::Text(name)) = named.into_iter().flatten().next() else {
        return Err("it does not say its kind (`clip.projector_type`)".into());
    };
    if let Some((_, reason)) = REFUSED.iter().find(|(refused, _)| refused == name) {
        return Err(format!("projectors of the kind `{name}` do not work here: {reason}"));
    }
    let Some((_, projection)) = KINDS.iter().find(|(kind, _)| kind == name) else {
        return Ok(Facts { width: None });
    };
    let encoder = Encoder::of(header)?;
    encoder.check()?;
    Ok(Facts {
        width: projection(&encoder)?,
    })
}

/// Two layers, as in LLaVA.
fn mlp(encoder: &Encoder<'_>) -> Result<Option<u64>, String> {
    let Tensors(header) = encoder.tensors;
    if header.tensors.contains_key("mm.3.weight") {
        // Another arrangement under the same name, which llama.cpp checks.
        return Ok(None);
    }
    encoder.has_separate_attention()?;
    let [width, places, ..] = encoder.tensors.shape("v.position_embd.weight")?;
    if width != encoder.width {
        return Err(format!(
            "its places for patches have {width} numbers, and its patches {}",
            encoder.width
        ));
    }
    let needed = encoder.patches() + u64::from(header.tensors.contains_key("v.class_embd"));
    if places < needed {
        return Err(format!("it has {places} places for {needed} patches of a picture"));
    }
    encoder.two_layers(encoder.width).map(Some)
}

/// Several patches side by side in one embedding, and one layer.
fn idefics3(encoder: &Encoder<'_>) -> Result<Option<u64>, String> {
    encoder.has_place_for_each_patch()?;
    let Tensors(header) = encoder.tensors;
    let scale = number(header, "clip.vision.projector.scale_factor", 2, 64)?;
    let scale = scale.ok_or("it has no number `clip.vision.projector.scale_factor`")?;
    let input = encoder.width * u64::from(scale).pow(2);
    encoder.tensors.linear("mm.model.fc", input).map(Some)
}

/// The mean of several patches, and one layer, which is stored the other way round.
fn gemma3(encoder: &Encoder<'_>) -> Result<Option<u64>, String> {
    encoder.has_place_for_each_patch()?;
    let Tensors(header) = encoder.tensors;
    let scale = number(header, "clip.vision.projector.scale_factor", 1, 64)?;
    let scale = u64::from(scale.unwrap_or(4));
    if !(encoder.side / encoder.patch).is_multiple_of(scale) {
        return Err(format!(
            "its pictures cannot be cut into squares of {scale} by {scale} patches"
        ));
    }
    encoder.tensors.vector("mm.soft_emb_norm.weight", encoder.width)?;
    let shape = encoder.tensors.shape("mm.input_projection.weight")?;
    expect("mm.input_projection.weight", shape, [shape[0], encoder.width, 1, 1])?;
    Ok(Some(shape[0]))
}

/// Pictures of any size; four patches in one embedding, and two layers.
fn qwen2vl(encoder: &Encoder<'_>) -> Result<Option<u64>, String> {
    let [name, second] = ["v.patch_embd.weight", "v.patch_embd.weight.1"];
    let (shape, other) = (encoder.tensors.shape(name)?, encoder.tensors.shape(second)?);
    expect(second, other, shape)?;
    for layer in 0..encoder.layers {
        for part in ["attn_q", "attn_k", "attn_v"] {
            encoder
                .tensors
                .vector(&format!("v.blk.{layer}.{part}.bias"), encoder.width)?;
        }
    }
    encoder.two_layers(4 * encoder.width).map(Some)
}

/// The vision encoder of a projector: a transformer over the patches of a picture.
struct Encoder<'a> {
    tensors: Tensors<'a>,
    /// The numbers of an embedding.
    width: u64,
    layers: u64,
    /// The pixels of a side of a picture, and of a patch.
    side: u64,
    patch: u64,
}

impl<'a> Encoder<'a> {
    fn of(header: &'a Header) -> Result<Self, String> {
        let of = |name: &str| {
            let key = format!("clip.vision.{name}");
            let found = number(header, &key, 1, u32::MAX)?;
            found.map(u64::from).ok_or_else(|| format!("it has no number `{key}`"))
        };
        let (width, heads) = (of("embedding_length")?, of("attention.head_count")?);
        if !width.is_multiple_of(heads) {
            return Err(format!("{heads} heads cannot share embeddings of {width} numbers"));
        }
        let (side, patch) = (of("image_size")?, of("patch_size")?);
        if patch > side {
            return Err(format!(
                "its patches of {patch} pixels are larger than its pictures of {side}"
            ));
        }
        Ok(Self {
            tensors: Tensors(header),
            width,
            layers: of("block_count")?,
            side,
            patch,
        })
    }

    /// The number of patches of a picture of the usual size.
    fn patches(&self) -> u64 {
        (self.side / self.patch).pow(2)
    }

    fn has_place_for_each_patch(&self) -> Result<(), String> {
        let name = "v.position_embd.weight";
        expect(name, self.tensors.shape(name)?, [self.width, self.patches(), 1, 1])
    }

    /// Checks two layers with biases behind the encoder; returns how many numbers they make.
    fn two_layers(&self, input: u64) -> Result<u64, String> {
        let inner = self.tensors.linear("mm.0", input)?;
        self.tensors.vector("mm.0.bias", inner)?;
        let width = self.tensors.linear("mm.2", inner)?;
        self.tensors.vector("mm.2.bias", width)?;
        Ok(width)
    }

    /// Checks that the inputs of attention are three tensors, and not one.
    fn has_separate_attention(&self) -> Result<(), String> {
        let names = (0..self.layers).map(|layer| format!("v.blk.{layer}.attn_qkv.weight"));
        let joint = names.into_iter().find(|name| self.tensors.has(name));
        joint.map_or(Ok(()), |name| {
            Err(format!("its tensor `{name}` does not belong to its kind"))
        })
    }

    /// Checks the tensors that all kinds have.
    fn check(&self) -> Result<(), String> {
        let Self {
            tensors, width, patch, ..
        } = self;
        let name = "v.patch_embd.weight";
        expect(name, tensors.shape(name)?, [*patch, *patch, 3, *width])?;
        for name in ["v.patch_embd.bias", "v.class_embd"] {
            tensors.vector_if_any(name, *width)?;
        }
        for name in ["v.pre_ln", "v.post_ln"] {
            tensors.vector_if_any(&format!("{name}.weight"), *width)?;
            tensors.vector_if_any(&format!("{name}.bias"), *width)?;
        }
        (0..self.layers).try_for_each(|layer| self.check_layer(&format!("v.blk.{layer}.")))
    }

    fn check_layer(&self, block: &str) -> Result<(), String> {
        let Self { tensors, width, .. } = self;
        for norm in ["ln1", "ln2"] {
            tensors.vector(&format!("{block}{norm}.weight"), *width)?;
            tensors.vector_if_any(&format!("{block}{norm}.bias"), *width)?;
        }
        let outputs = match tensors.has(&format!("{block}attn_qkv.weight")) {
            true => &[("attn_qkv", 3), ("attn_out", 1)][..],
            false => &[("attn_q", 1), ("attn_k", 1), ("attn_v", 1), ("attn_out", 1)],
        };
        for (part, times) in outputs {
            let name = format!("{block}{part}");
            tensors.linear_to(&name, *width, times * width)?;
        }
        let mut names = [format!("{block}ffn_up"), format!("{block}ffn_down")];
        // In old files the two are swapped, which llama.cpp sees by the same sign.
        if tensors.shape(&format!("{}.weight", names[1]))?[0] == *width {
            names.swap(0, 1);
        }
        let inner = tensors.linear(&names[0], *width)?;
        tensors.linear_to(&names[1], inner, *width)?;
        match tensors.has(&format!("{block}ffn_gate.weight")) {
            true => tensors.linear_to(&format!("{block}ffn_gate"), *width, inner),
            false => Ok(()),
        }
    }
}

/// The tensors of a file.
#[derive(Clone, Copy)]
struct Tensors<'a>(&'a Header);

impl Tensors<'_> {
    fn has(&self, name: &str) -> bool {
        self.0.tensors.contains_key(name)
    }

    fn shape(&self, name: &str) -> Result<[u64; 4], String> {
        let found = self.0.tensors.get(name);
        found
            .map(|own| own.shape)
            .ok_or_else(|| format!("it has no tensor `{name}`"))
    }

    /// Checks a list of numbers that are added or multiplied as they are.
    fn vector(&self, name: &str, length: u64) -> Result<(), String> {
        expect(name, self.shape(name)?, [length, 1, 1, 1])?;
        match self.0.tensors.get(name).is_some_and(|own| own.is_f32) {
            true => Ok(()),
            false => Err(format!("its tensor `{name}` has another number format than F32")),
        }
    }

    fn vector_if_any(&self, name: &str, length: u64) -> Result<(), String> {
        match self.has(name) {
            true => self.vector(name, length),
            false => Ok(()),
        }
    }

    /// Checks a layer from so many numbers, with a bias or without; returns how many it makes.
    fn linear(&self, name: &str, input: u64) -> Result<u64, String> {
        let weight = format!("{name}.weight");
        let shape = self.shape(&weight)?;
        expect(&weight, shape, [input, shape[1], 1, 1])?;
        self.vector_if_any(&format!("{name}.bias"), shape[1])?;
        Ok(shape[1])
    }

    fn linear_to(&self, name: &str, input: u64, output: u64) -> Result<(), String> {
        let weight = format!("{name}.weight");
        expect(&weight, self.shape(&weight)?, [input, output, 1, 1])?;
        self.linear(name, input).map(|_| ())
    }
}

/// Checks the shape of a tensor.
fn expect(name: &str, found: [u64; 4], expected: [u64; 4]) -> Result<(), String> {
    match found == expected {
        true => Ok(()),
        false => Err(format!(
            "its tensor `{name}` has the shape {found:?}, and its numbers say {expected:?}"
        )),
    }
}

/// Returns a number of the metadata.
fn number(header: &Header, key: &str, least: u32, most: u32) -> Result<Option<u32>, String> {
    match header.values.get(key) {
        None => Ok(None),
        Some(Value::U32(own)) if (least..=most).contains(own) => Ok(Some(*own)),
        Some(Value::U32(own)) => Err(format!("its `{key}` is {own}, not {least} to {most}")),
        Some(_) => Err(format!("its `{key}` is not a number of the right kind")),
    }
}
