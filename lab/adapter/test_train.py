#!/usr/bin/env python3
"""Tests of the training on a tiny random model: seconds, and no download. They need requirements.txt: lab/adapter/test_train.py

`all.sh` runs them before it trains.
"""

import collections
import contextlib
import io
import json
import math
import random
import tempfile
import unittest
from pathlib import Path
from typing import Any, cast

import gguf
import numpy
import torch
import torch.nn.functional as F
from torch import Tensor

import train
from qwen2 import (
    LINEAR_LAYERS, Block, LoraFunction, LoraLinear, Qwen2, QwenTokenizer, apply_rotary, load_adapter, rms_norm, rotary_cos_sin,
    save_adapter,
)
from sequences import Case, PackedSequence, concatenate, draw_examples, group_cases, pack_cases, shuffle_lists

# Threads only get into each other's way in a model of this size.
torch.set_num_threads(1)

HIDDEN, FFN, HEADS, KV_HEADS, BLOCKS, RANK = 64, 96, 4, 2, 2, 4
HEAD_DIM = HIDDEN // HEADS
ROPE_THETA = 10_000.0
SPECIAL_TOKENS = ["<|im_start|>", "<|im_end|>"]


def byte_tokens() -> list[str]:
    """Returns the letters that byte-level BPE writes for the 256 bytes."""
    printable = [*range(ord("!"), ord("~") + 1), *range(ord("¡"), ord("¬") + 1), *range(ord("®"), ord("ÿ") + 1)]
    others = [byte for byte in range(256) if byte not in printable]
    return [chr(byte) for byte in printable] + [chr(256 + index) for index in range(len(others))]


def write_model(path: Path, seed: int = 1) -> None:
    """Writes a random model of 0.1 million weights with a tokenizer for bytes."""
    rng = numpy.random.default_rng(seed)
    writer = gguf.GGUFWriter(path, "qwen2")
    tokens = byte_tokens() + ["qu", "Ġt", *SPECIAL_TOKENS]
    writer.add_tokenizer_model("gpt2")
    writer.add_token_list(tokens)
    writer.add_token_merges(["q u", "Ġ t"])
    writer.add_block_count(BLOCKS)
    writer.add_head_count(HEADS)
    writer.add_head_count_kv(KV_HEADS)
    writer.add_layer_norm_rms_eps(1e-6)
    writer.add_rope_freq_base(ROPE_THETA)

    def add(name: str, *shape: int, scale: float = 0.15, mean: float = 0.0) -> None:
        writer.add_tensor(name, rng.normal(mean, scale, shape).astype(numpy.float32))

    add("token_embd.weight", len(tokens), HIDDEN, scale=1.0)
    add("output_norm.weight", HIDDEN, mean=1.0)
    kv_size = KV_HEADS * HEAD_DIM
    for block in range(BLOCKS):
        for name, out_features, in_features in [
            ("attn_q", HIDDEN, HIDDEN), ("attn_k", kv_size, HIDDEN), ("attn_v", kv_size, HIDDEN), ("attn_output", HIDDEN, HIDDEN),
            ("ffn_gate", FFN, HIDDEN), ("ffn_up", FFN, HIDDEN), ("ffn_down", HIDDEN, FFN),
        ]:
            add(f"blk.{block}.{name}.weight", out_features, in_features)
            if name in ("attn_q", "attn_k", "attn_v"):
                add(f"blk.{block}.{name}.bias", out_features)
        add(f"blk.{block}.attn_norm.weight", HIDDEN, mean=1.0)
        add(f"blk.{block}.ffn_norm.weight", HIDDEN, mean=1.0)
    writer.write_header_to_file()
    writer.write_kv_data_to_file()
    writer.write_tensors_to_file()
    writer.close()


def case(instruction: str, answer: str | None, **others: Any) -> Case:
    fixed = [("system", "Goals:\n- put(ITEM, PLACE)\n- wiped(ITEM)"), ("user", "Clean up"), ("assistant", "wiped(mug)")]
    own = {"suite": "tiny", "fixed": fixed, "lead": "Objects:\n- cup\n- mug\nInstruction:", "instruction": instruction, "answer": answer}
    return own | others  # type: ignore[return-value]


CASES = [
    case(" Cup to the shelf", "put(cup, shelf)"),
    case(" Wipe it", None),
    case(" Wipe the quiche", "wiped(quiche)", rounds=[("question: Which one?", " The round one")]),
    case(" Mug too", "put(mug, shelf)"),
]
PLAN_CASES = [
    case(" Leave out step 1", "drop 1", plan="1. take the cup\nThe person says:"),
    case(" Wait before step 2", "insert 2 wait", plan="1. take the cup\nThe person says:"),
    case(" Leave out step 2", "drop 2", plan="1. take the mug\n2. go\nThe person says:"),
]


class WithModel(unittest.TestCase):
    """A folder with the file of the tiny model."""

    folder: Path
    model_path: Path
    tokenizer: QwenTokenizer

    @classmethod
    def setUpClass(cls) -> None:
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)
        cls.model_path = cls.folder / "model.gguf"
        write_model(cls.model_path)
        cls.tokenizer = QwenTokenizer(gguf.GGUFReader(cls.model_path).fields)

    def model(self, seed: int = 1, has_random_b: bool = True) -> Qwen2:
        """Returns the model in 32 bits; B is random, since the zeros of a new adapter would hide mistakes."""
        torch.manual_seed(seed)
        model = Qwen2(gguf.GGUFReader(self.model_path), RANK, 2 * RANK, "cpu", dtype=torch.float32)
        if has_random_b:
            for layer in model.lora_layers().values():
                torch.nn.init.normal_(layer.lora_b, std=0.1)
        return model

    def pack(self, cases: list[Case], **options: Any) -> PackedSequence:
        return pack_cases(self.tokenizer, cases, random.Random(1), None, **options)

    def logits(self, model: Qwen2, sequence: PackedSequence) -> Tensor:
        with torch.no_grad():
            return train.forward_loss(model, sequence)[0]


class Layers(unittest.TestCase):
    def test_lora_gradients_are_finite_differences(self) -> None:
        torch.manual_seed(1)
        x, lora_a, lora_b = (torch.randn(*shape, dtype=torch.float64, requires_grad=True) for shape in [(3, 6), (2, 6), (5, 2)])
        weight, bias = torch.randn(5, 6, dtype=torch.float64), torch.randn(5, dtype=torch.float64)
        is_right = torch.autograd.gradcheck(
            lambda x, lora_a, lora_b: LoraFunction.apply(x, weight, bias, lora_a, lora_b, 2.0),
            (x, lora_a, lora_b), eps=1e-4, atol=1e-5,
        )
        self.assertTrue(is_right)

    def test_lora_adds_scaled_low_rank_matrices(self) -> None:
        torch.manual_seed(1)
        layer = LoraLinear(torch.randn(5, 6), torch.randn(5), rank=2, alpha=6)
        x = torch.randn(3, 6)
        torch.testing.assert_close(layer(x), F.linear(x, layer.weight, layer.bias))
        torch.nn.init.normal_(layer.lora_b)
        merged = layer.weight + 3 * layer.lora_b @ layer.lora_a
        torch.testing.assert_close(layer(x), F.linear(x, merged, layer.bias))

    def test_rms_norm_is_its_formula(self) -> None:
        torch.manual_seed(1)
        x, weight = torch.randn(3, 8), torch.randn(8)
        expected = torch.stack([row / math.sqrt(float((row ** 2).mean()) + 0.5) * weight for row in x])
        torch.testing.assert_close(rms_norm(x, weight, 0.5), expected)

    def test_rotary_embedding_multiplies_complex_numbers(self) -> None:
        torch.manual_seed(1)
        position_ids, half = torch.tensor([0, 1, 5, 300]), HEAD_DIM // 2
        x = torch.randn(HEADS, len(position_ids), HEAD_DIM)
        rotated = apply_rotary(x, *rotary_cos_sin(position_ids, HEAD_DIM, ROPE_THETA, torch.float32))
        for index, position in enumerate(position_ids.tolist()):
            for dimension in range(half):
                angle = position * ROPE_THETA ** (-2 * dimension / HEAD_DIM)
                pair = torch.complex(x[:, index, dimension], x[:, index, dimension + half]) * complex(math.cos(angle), math.sin(angle))
                torch.testing.assert_close(rotated[:, index, dimension], pair.real, atol=1e-4, rtol=1e-4)
                torch.testing.assert_close(rotated[:, index, dimension + half], pair.imag, atol=1e-4, rtol=1e-4)


class Model(WithModel):
    def test_the_gradient_of_the_loss_is_a_finite_difference(self) -> None:
        """Along a random direction of each parameter of the whole model."""
        model, sequence, step = self.model(), self.pack(CASES[:3]), 1e-2
        train.forward_loss(model, sequence)[1].backward()  # type: ignore[no-untyped-call]
        for name, parameter in model.named_parameters():
            assert parameter.grad is not None
            direction = torch.randn_like(parameter) + parameter.grad / parameter.grad.norm()
            direction /= direction.norm()
            losses = []
            for side in (step, -step):
                with torch.no_grad():
                    parameter.add_(side * direction)
                    losses.append(train.forward_loss(model, sequence)[1].double())
                    parameter.sub_(side * direction)
            difference = float(losses[0] - losses[1]) / (2 * step)
            self.assertAlmostEqual(difference / float((parameter.grad * direction).sum()), 1, delta=0.03, msg=name)

    def test_a_branch_has_the_logits_of_its_case_alone(self) -> None:
        model = self.model()
        for cases in (CASES, PLAN_CASES):
            packed = self.pack(cases)
            logits = self.logits(model, packed)
            for index, own in enumerate(cases):
                alone = self.pack([own])
                is_own = torch.tensor([case_index == index for case_index in packed.target_cases])
                torch.testing.assert_close(packed.targets[is_own], alone.targets)
                torch.testing.assert_close(logits[is_own], self.logits(model, alone), atol=1e-4, rtol=1e-4)

    def test_sequences_in_one_step_do_not_see_each_other(self) -> None:
        model, sequences = self.model(), [self.pack(CASES), self.pack(PLAN_CASES)]
        joint = self.logits(model, concatenate(sequences))
        torch.testing.assert_close(joint, torch.cat([self.logits(model, own) for own in sequences]), atol=1e-4, rtol=1e-4)

    def test_a_token_sees_no_later_one(self) -> None:
        model, sequence = self.model(), self.pack(CASES[:1])
        changed = sequence.input_ids.clone()
        last = int(sequence.target_positions[-1]) + 1
        changed[last] = 0
        torch.testing.assert_close(self.logits(model, sequence._replace(input_ids=changed)), self.logits(model, sequence))


    def test_attention_is_its_formula_with_a_key_head_for_each_group(self) -> None:
        block, x, mask = cast(Block, self.model().blocks[0]), torch.randn(5, HIDDEN), torch.ones(5, 5).tril().bool()
        rotation = rotary_cos_sin(torch.arange(5), HEAD_DIM, ROPE_THETA, torch.float32)
        with torch.no_grad():
            query, key, value = (block.layers[name](x).split(HEAD_DIM, dim=1) for name in ("attn_q", "attn_k", "attn_v"))
            heads = []
            for head in range(HEADS):
                group = head // (HEADS // KV_HEADS)
                own_query, own_key = apply_rotary(query[head], *rotation), apply_rotary(key[group], *rotation)
                scores = (own_query @ own_key.t() / math.sqrt(HEAD_DIM)).masked_fill(~mask, -math.inf)
                heads.append(scores.softmax(-1) @ value[group])
            expected = block.layers["attn_output"](torch.cat(heads, dim=1))
            torch.testing.assert_close(block.attention(x, *rotation, mask), expected, atol=1e-4, rtol=1e-4)


class Sequences(WithModel):
    def test_the_tokenizer_encodes_bytes_merges_and_messages(self) -> None:
        text = "Wipe the quiche, größer 拭く"
        tokens = self.tokenizer.encode(text)
        self.assertEqual(self.tokenizer.bpe.decode(tokens), text)
        self.assertIn(self.tokenizer.token_ids["qu"], tokens)
        start, end = (self.tokenizer.token_ids[token] for token in SPECIAL_TOKENS)
        expected = [start, *self.tokenizer.encode("user\nHi"), end, *self.tokenizer.encode("\n")]
        self.assertEqual(self.tokenizer.encode_message("user", "Hi"), expected)

    def test_targets_are_answers_and_the_beginning_of_questions(self) -> None:
        sequence = self.pack(CASES)
        for index, own in enumerate(CASES):
            targets = [token for token, owner in zip(sequence.targets.tolist(), sequence.target_cases) if owner == index]
            answer = self.tokenizer.encode("question:" if own["answer"] is None else own["answer"])
            self.assertEqual(targets, answer if own["answer"] is None else answer + self.tokenizer.encode_end())
        torch.testing.assert_close(sequence.input_ids[sequence.target_positions + 1], sequence.targets)

    def test_a_case_alone_is_the_conversation_of_a_session(self) -> None:
        tokenizer = self.tokenizer
        [system, question, answer] = CASES[2]["fixed"]
        messages = [system, question, answer, ("user", CASES[2]["lead"] + CASES[2]["instruction"]), ("assistant", "question: Which one?"),
                    ("user", " The round one"), ("assistant", "wiped(quiche)")]
        sequence = self.pack([CASES[2]])
        conversation = [token for message in messages for token in tokenizer.encode_message(*message)]
        self.assertEqual(sequence.input_ids.tolist(), conversation[:-len(tokenizer.encode("\n"))])
        self.assertEqual(sequence.position_ids.tolist(), list(range(len(sequence.input_ids))))

    def test_a_case_alone_sees_all_that_is_before(self) -> None:
        for own in (CASES[2], PLAN_CASES[0]):
            mask = self.pack([own]).attention_mask
            self.assertTrue(torch.equal(mask, torch.ones_like(mask).tril()))

    def test_an_epoch_has_all_cases_and_its_share_of_those_that_are_seen_once(self) -> None:
        groups = train.draw_packs(CASES, PLAN_CASES, 1, 3, random.Random(1))
        counts = collections.Counter(own["instruction"] for group in groups for own in group)
        self.assertEqual(counts, {**{own["instruction"]: 3 for own in CASES}, **{own["instruction"]: 1 for own in PLAN_CASES}})

    def test_groups_have_each_case_once_and_one_scene(self) -> None:
        other = [case(f" {number}", "wiped(cup)", lead="Objects:\n- pan\nInstruction:") for number in range(20)]
        groups = group_cases(CASES + other, 5, random.Random(1))
        self.assertEqual(sorted(own["instruction"] for group in groups for own in group), sorted(c["instruction"] for c in CASES + other))
        self.assertTrue(all(len({own["lead"] for own in group}) == 1 and len(group) <= 6 for group in groups))

    def test_lists_are_shuffled_and_other_lines_stay(self) -> None:
        text = "Goals:\n- a\n- b\n- c\n- d\n\nMore:\n- e\n- f"
        shuffled = {shuffle_lists(text, random.Random(seed)) for seed in range(20)}
        self.assertGreater(len(shuffled), 10)
        for own in shuffled:
            lines = own.split("\n")
            self.assertEqual([lines[0], lines[5], lines[6]], ["Goals:", "", "More:"])
            self.assertEqual((sorted(lines[1:5]), sorted(lines[7:])), (["- a", "- b", "- c", "- d"], ["- e", "- f"]))

    def test_the_limit_of_examples_is_kept(self) -> None:
        rng, examples = random.Random(1), list(range(10))
        self.assertEqual(draw_examples(examples, None, rng), examples)
        self.assertEqual({len(draw_examples(examples, 3, rng)) for _ in range(100)}, {0, 1, 2, 3})
        counts = [len(draw_examples(examples, "any", rng)) for _ in range(1000)]
        self.assertAlmostEqual(counts.count(0) / 1000, 0.4 + 0.3 / 11, delta=0.05)
        self.assertEqual(max(counts), 10)


class Files(WithModel):
    def test_an_adapter_is_written_and_read_back(self) -> None:
        path, model, other = str(self.folder / "adapter.gguf"), self.model(1), self.model(2)
        save_adapter(path, model, 2 * RANK, "goals")
        load_adapter(path, other)
        for name, layer in model.lora_layers().items():
            read = other.lora_layers()[name]
            torch.testing.assert_close(read.lora_b, layer.lora_b.half().float(), atol=0, rtol=0)
            # 8 bits of the greatest value of a block.
            self.assertLessEqual(float((read.lora_a - layer.lora_a).detach().abs().max()), float(layer.lora_a.detach().abs().max()) / 127)

    def test_an_adapter_has_what_llama_cpp_reads(self) -> None:
        path = self.folder / "adapter.gguf"
        save_adapter(str(path), self.model(), 2 * RANK, "plans")
        reader = gguf.GGUFReader(path)
        fields = {name: reader.fields[name].contents() for name in
                  ["general.architecture", "general.type", "adapter.type", "adapter.lora.alpha", "longstep.task"]}
        self.assertEqual(list(fields.values()), ["qwen2", "adapter", "lora", 2.0 * RANK, "plans"])
        tensors = {tensor.name: tensor for tensor in reader.tensors}
        names = {f"blk.{block}.{layer}.weight.lora_{part}" for block in range(BLOCKS) for layer in LINEAR_LAYERS for part in "ab"}
        self.assertEqual(set(tensors), names)
        # GGUF lists dimensions from the innermost.
        self.assertEqual(tensors["blk.0.ffn_down.weight.lora_a"].shape.tolist(), [FFN, RANK])
        self.assertEqual(tensors["blk.0.ffn_down.weight.lora_b"].shape.tolist(), [RANK, HIDDEN])
        self.assertEqual(tensors["blk.0.attn_q.weight.lora_a"].tensor_type, gguf.GGMLQuantizationType.Q8_0)
        self.assertEqual(tensors["blk.0.attn_q.weight.lora_b"].tensor_type, gguf.GGMLQuantizationType.F16)


class Update(WithModel):
    def setUp(self) -> None:
        options = train.parse_arguments(["data", "model", "adapter"])
        self.trainer = train.Trainer(self.model(), self.tokenizer, options, random.Random(1))
        self.weights = [parameter.detach().clone() for parameter in self.trainer.parameters]

    def update(self, gradient: float) -> list[Tensor]:
        """Accumulates a gradient over ten targets, updates, and returns the gradients that the optimizer saw."""
        seen: list[Tensor] = []
        self.trainer.optimizer.register_step_pre_hook(
            lambda *_: seen.extend(cast(Tensor, own.grad).clone() for own in self.trainer.parameters)
        )
        for parameter in self.trainer.parameters:
            parameter.grad = torch.full_like(parameter, gradient)
        self.trainer.accumulated_targets, self.trainer.accumulated_cases = 10, 3
        with contextlib.redirect_stdout(io.StringIO()):
            self.trainer.update(0)
        self.assertEqual((self.trainer.accumulated_targets, self.trainer.accumulated_cases), (0, 0))
        self.assertTrue(all(own.grad is None or not own.grad.any() for own in self.trainer.parameters))
        return seen

    def test_a_gradient_is_averaged_over_its_targets(self) -> None:
        for gradient in self.update(1e-3):
            torch.testing.assert_close(gradient, torch.full_like(gradient, 1e-4))

    def test_a_large_gradient_is_clipped(self) -> None:
        norm = torch.cat([gradient.flatten() for gradient in self.update(1e6)]).norm()
        self.assertAlmostEqual(float(norm), 1, delta=1e-3)

    def test_a_gradient_that_is_not_finite_changes_nothing(self) -> None:
        self.assertEqual(self.update(math.nan), [])
        self.assertTrue(all(torch.equal(own, old) for own, old in zip(self.trainer.parameters, self.weights)))


class Training(WithModel):
    def train(self, name: str, *arguments: str) -> tuple[bytes, str]:
        """Returns the adapter that the program writes, and its log."""
        data, plans, adapter = self.folder / "data.jsonl", self.folder / "plans.jsonl", self.folder / name
        data.write_text("".join(json.dumps(own) + "\n" for own in CASES))
        plans.write_text("".join(json.dumps(own) + "\n" for own in PLAN_CASES))
        log = io.StringIO()
        with contextlib.redirect_stdout(log):
            train.main([str(data), str(self.model_path), str(adapter), "--once", str(plans), "--rank", str(RANK), "--examples", "any",
                        "--mixed", "0.5", "--pack", "3", "--measure", str(data), *arguments])
        return adapter.read_bytes(), log.getvalue()

    def test_a_seed_decides_every_byte(self) -> None:
        first, _ = self.train("first.gguf", "--epochs", "2", "--scenes", "2", "--seed", "3")
        again, _ = self.train("again.gguf", "--epochs", "2", "--scenes", "2", "--seed", "3")
        other, _ = self.train("other.gguf", "--epochs", "2", "--scenes", "2", "--seed", "4")
        self.assertEqual(first, again)
        self.assertNotEqual(first, other)

    def test_training_learns_the_answers_and_continues_from_an_adapter(self) -> None:
        self.train("start.gguf", "--epochs", "50", "--rate", "0.01")
        _, log = self.train("continued.gguf", "--start", str(self.folder / "start.gguf"), "--minutes", "0.0000001")
        self.assertIn("tiny: 4 of 4", log)
        self.assertIn("4 of 4 word for word, 0 needless questions, 0 missing questions", log)
        _, log = self.train("untrained.gguf", "--minutes", "0.0000001")
        self.assertIn("tiny: 0 of 4", log)

    def test_the_learning_rate_rises_and_falls(self) -> None:
        rates = [train.learning_rate(1.0, step, step / 100) for step in range(101)]
        self.assertAlmostEqual(rates[0], 1 / 8, delta=0.01)
        self.assertAlmostEqual(max(rates), 1, delta=0.02)
        self.assertEqual(rates.index(max(rates)), 7)
        self.assertAlmostEqual(rates[100], 0.05)


if __name__ == "__main__":
    unittest.main()
