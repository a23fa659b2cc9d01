"""Writes a tiny language model and projectors for it, with random weights, in the formats that llama.cpp loads.

The tests of embedded vision run them: there is no small vision model that every machine has. They are senseless, and small
enough to be made in a second: a vocabulary learned from a text of this repository, two layers, and a vision encoder for
pictures of 32 by 32 pixels.

    python tiny.py FOLDER --text crates/longstep-model/domains/household/domain.toml

writes `model.gguf` and `mrope.gguf` (a model whose positions have several dimensions), and projectors: `mlp.gguf` (one
piece of 16 tokens a picture), `tiles.gguf` (a picture in tiles, with tokens between them), `sizes.gguf` (as many tokens as
the picture has pieces, for `mrope.gguf`), `whole.gguf` (attention in both directions within a picture) and `wide.gguf` (for
another model). The same arguments write the same bytes.
"""

import argparse
import collections
import pathlib
import re

import gguf
import numpy as np

WIDTH = 64  # of the language model's embeddings
LAYERS = 2
HEADS = 4
INNER = 128
CONTEXT = 32768
VISION_WIDTH = 32
VISION_INNER = 64
PATCH = 8
SIDE = 32

MERGES = 300
CONTROL = ["<|endoftext|>", "<|im_start|>", "<|im_end|>", "<|vision_start|>", "<|vision_end|>"]
CONTROL += ["<fake_token_around_image>", "<global-img>", "<start_of_image>", "<end_of_image>"]
CONTROL += [f"<row_{row}_col_{column}>" for row in range(1, 9) for column in range(1, 9)]
# llama.cpp recognises this text as its template `chatml`.
TEMPLATE = (
    "{% for message in messages %}{{'<|im_start|>' + message['role'] + '\n' + message['content'] + '<|im_end|>' + '\n'}}"
    "{% endfor %}{% if add_generation_prompt %}{{ '<|im_start|>assistant\n' }}{% endif %}"
)


def byte_letters():
    """Returns the letter that stands for each byte in a byte-level vocabulary: itself, or one that can be printed."""
    plain = [*range(ord("!"), ord("~") + 1), *range(0xA1, 0xAD), *range(0xAE, 0x100)]
    letters = {byte: chr(byte) for byte in plain}
    for byte in range(256):
        letters.setdefault(byte, chr(256 + len(letters) - len(plain)))
    return letters


def learned(text):
    """Returns the tokens and merges of a byte-pair encoding of the text."""
    letters = byte_letters()
    words = collections.Counter(re.findall(r" ?[A-Za-z]+|[0-9]|[^A-Za-z0-9\s]+|\s+", text))
    pieces = {word: tuple(letters[byte] for byte in word.encode()) for word in words}
    tokens = [letters[byte] for byte in range(256)]
    merges = []
    for _ in range(MERGES):
        pairs = collections.Counter()
        for word, count in words.items():
            for pair in zip(pieces[word], pieces[word][1:]):
                pairs[pair] += count
        if not pairs:
            break
        best = max(pairs, key=lambda pair: (pairs[pair], pair))
        merges.append(" ".join(best))
        # Two pairs of pieces may join to one token.
        if "".join(best) not in tokens:
            tokens.append("".join(best))
        for word, own in pieces.items():
            joined, index = [], 0
            while index < len(own):
                if own[index : index + 2] == best:
                    joined.append("".join(best))
                    index += 2
                else:
                    joined.append(own[index])
                    index += 1
            pieces[word] = tuple(joined)
    return tokens, merges


class Weights:
    """Random tensors, by a seed of the file."""

    def __init__(self, writer, seed):
        self.writer = writer
        self.random = np.random.default_rng(seed)

    def add(self, name, *shape, scale=0.2):
        values = self.random.normal(0.0, scale, shape).astype(np.float32)
        self.writer.add_tensor(name, values)

    def norm(self, name, width):
        """A norm whose weights are near 1."""
        values = 1.0 + self.random.normal(0.0, 0.05, width).astype(np.float32)
        self.writer.add_tensor(name + ".weight", values.astype(np.float32))

    def both(self, name, *shape):
        """Weights and a bias."""
        self.add(name + ".weight", *shape)
        self.add(name + ".bias", shape[0], scale=0.02)

    def norm_with_bias(self, name, width):
        self.norm(name, width)
        self.add(name + ".bias", width, scale=0.02)


def finish(writer):
    writer.write_header_to_file()
    writer.write_kv_data_to_file()
    writer.write_tensors_to_file()
    writer.close()


def language_model(path, architecture, vocabulary, merges, seed):
    writer = gguf.GGUFWriter(path, architecture)
    writer.add_name(f"tiny {architecture}, random weights")
    writer.add_context_length(CONTEXT)
    writer.add_embedding_length(WIDTH)
    writer.add_block_count(LAYERS)
    writer.add_feed_forward_length(INNER)
    writer.add_head_count(HEADS)
    writer.add_head_count_kv(HEADS)
    writer.add_layer_norm_rms_eps(1e-5)
    writer.add_rope_freq_base(10000.0)
    with_bias = architecture == "qwen2vl"
    if with_bias:
        writer.add_rope_dimension_sections([2, 3, 3, 0])
    else:
        writer.add_rope_dimension_count(WIDTH // HEADS)
    tokens = vocabulary + CONTROL
    writer.add_tokenizer_model("gpt2")
    writer.add_tokenizer_pre("qwen2")
    writer.add_token_list(tokens)
    kinds = [gguf.TokenType.NORMAL] * len(vocabulary) + [gguf.TokenType.CONTROL] * len(CONTROL)
    writer.add_token_types(kinds)
    writer.add_token_merges(merges)
    writer.add_bos_token_id(tokens.index("<|endoftext|>"))
    writer.add_eos_token_id(tokens.index("<|im_end|>"))
    writer.add_add_bos_token(False)
    writer.add_chat_template(TEMPLATE)
    weights = Weights(writer, seed)
    weights.add("token_embd.weight", len(tokens), WIDTH, scale=1.0)
    weights.norm("output_norm", WIDTH)
    weights.add("output.weight", len(tokens), WIDTH)
    for layer in range(LAYERS):
        block = f"blk.{layer}."
        weights.norm(block + "attn_norm", WIDTH)
        for name in ("attn_q", "attn_k", "attn_v"):
            weights.add(block + name + ".weight", WIDTH, WIDTH)
            if with_bias:
                weights.add(block + name + ".bias", WIDTH, scale=0.02)
        weights.add(block + "attn_output.weight", WIDTH, WIDTH)
        weights.norm(block + "ffn_norm", WIDTH)
        weights.add(block + "ffn_gate.weight", INNER, WIDTH)
        weights.add(block + "ffn_up.weight", INNER, WIDTH)
        weights.add(block + "ffn_down.weight", WIDTH, INNER)
    finish(writer)


def projector(path, kind, width, seed):
    writer = gguf.GGUFWriter(path, "clip")
    writer.add_type("mmproj")
    writer.add_name(f"tiny {kind} projector, random weights")
    writer.add_clip_has_vision_encoder(True)
    writer.add_clip_projector_type(kind)
    writer.add_vision_image_size(SIDE)
    writer.add_vision_patch_size(PATCH)
    writer.add_vision_embedding_length(VISION_WIDTH)
    writer.add_vision_feed_forward_length(VISION_INNER)
    writer.add_vision_block_count(2)
    writer.add_vision_head_count(2)
    writer.add_vision_projection_dim(width)
    writer.add_vision_attention_layernorm_eps(1e-5)
    writer.add_vision_image_mean([0.5, 0.5, 0.5])
    writer.add_vision_image_std([0.5, 0.5, 0.5])
    writer.add_vision_use_gelu(True)
    weights = Weights(writer, seed)
    weights.add("v.patch_embd.weight", VISION_WIDTH, 3, PATCH, PATCH)
    if kind == "qwen2vl_merger":
        weights.add("v.patch_embd.weight.1", VISION_WIDTH, 3, PATCH, PATCH)
    else:
        weights.add("v.patch_embd.bias", VISION_WIDTH, scale=0.02)
        weights.add("v.position_embd.weight", (SIDE // PATCH) ** 2, VISION_WIDTH, scale=1.0)
    for layer in range(2):
        block = f"v.blk.{layer}."
        weights.norm_with_bias(block + "ln1", VISION_WIDTH)
        for name in ("attn_q", "attn_k", "attn_v", "attn_out"):
            weights.both(block + name, VISION_WIDTH, VISION_WIDTH)
        weights.norm_with_bias(block + "ln2", VISION_WIDTH)
        weights.both(block + "ffn_up", VISION_INNER, VISION_WIDTH)
        weights.both(block + "ffn_down", VISION_WIDTH, VISION_INNER)
    weights.norm_with_bias("v.post_ln", VISION_WIDTH)
    if kind == "mlp":
        weights.both("mm.0", width, VISION_WIDTH)
        weights.both("mm.2", width, width)
    elif kind == "idefics3":
        writer.add_vision_projector_scale_factor(2)
        writer.add_uint32("clip.vision.preproc_image_size", 4 * SIDE)
        weights.add("mm.model.fc.weight", width, 4 * VISION_WIDTH)
    elif kind == "qwen2vl_merger":
        weights.both("mm.0", 4 * VISION_WIDTH, 4 * VISION_WIDTH)
        weights.both("mm.2", width, 4 * VISION_WIDTH)
    elif kind == "gemma3":
        writer.add_vision_projector_scale_factor(2)
        weights.norm("mm.soft_emb_norm", VISION_WIDTH)
        weights.add("mm.input_projection.weight", VISION_WIDTH, width)
    finish(writer)


def main():
    parser = argparse.ArgumentParser(description="Writes a tiny vision model with random weights.")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--text", type=pathlib.Path, required=True, help="the text from which the vocabulary is learned")
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    vocabulary, merges = learned(arguments.text.read_text(encoding="utf-8"))
    for name, architecture, seed in (("model", "llama", 1), ("mrope", "qwen2vl", 2)):
        language_model(arguments.folder / f"{name}.gguf", architecture, vocabulary, merges, seed)
    for name, kind, width, seed in (
        ("mlp", "mlp", WIDTH, 3),
        ("tiles", "idefics3", WIDTH, 4),
        ("sizes", "qwen2vl_merger", WIDTH, 5),
        ("whole", "gemma3", WIDTH, 6),
        ("wide", "mlp", 2 * WIDTH, 7),
    ):
        projector(arguments.folder / f"{name}.gguf", kind, width, seed)


if __name__ == "__main__":
    main()
