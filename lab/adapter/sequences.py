"""Packs training cases into sequences: a scene once, and each of its instructions as a branch that sees the scene and itself.

Shapes in the docstrings: T tokens of a sequence, N tokens that are learned.
"""

import itertools
import json
import random
from collections.abc import Sequence
from typing import Literal, NamedTuple, NotRequired, TypedDict, TypeVar

import torch
from torch import Tensor

from qwen2 import QwenTokenizer

T = TypeVar("T")

# The beginning of an answer that is a question. Its words are composed by the program and not learned.
QUESTION = "question:"

# The number of worked examples in a prompt: at most so many, all of them (None), or mostly a few ("any").
ExampleLimit = int | Literal["any"] | None


class Case(TypedDict):
    """A case of the training data, a line of JSON from `training_data` (lab/programs) or `synthetic.py`."""

    suite: str
    # The fixed messages of the request, as pairs of role and text: the system prompt, then worked examples.
    fixed: list[tuple[str, str]]
    # The last message up to the instruction.
    lead: str
    # The plan that the instruction is about, for cases that change plans.
    plan: NotRequired[str]
    instruction: str
    # Earlier answers with the next message.
    rounds: NotRequired[list[tuple[str, str]]]
    # None for a question.
    answer: str | None


class PackedSequence(NamedTuple):
    """A sequence with its branches.

    input_ids and position_ids [T]; attention_mask [T, T], true where the row's token sees the column's; target_positions [N], the
    positions whose next token is learned; targets [N], these tokens; target_cases, the index of the case of each of them.
    """

    input_ids: Tensor
    position_ids: Tensor
    attention_mask: Tensor
    target_positions: Tensor
    targets: Tensor
    target_cases: list[int]


class SequenceBuilder:
    """Appends segments to a sequence. A token sees the earlier tokens of segment 0, of its own and of its parent segment."""

    def __init__(self) -> None:
        self.input_ids: list[int] = []
        self.position_ids: list[int] = []
        self.segment_ids: list[int] = []
        self.parent_ids: list[int] = []
        self.target_positions: list[int] = []
        self.targets: list[int] = []
        self.target_cases: list[int] = []

    def append(self, tokens: Sequence[int], first_position: int, segment: int, parent: int = 0) -> int:
        """Appends a segment, and returns the position behind its last token."""
        self.input_ids += tokens
        self.position_ids += range(first_position, first_position + len(tokens))
        self.segment_ids += [segment] * len(tokens)
        self.parent_ids += [parent] * len(tokens)
        return first_position + len(tokens)

    def learn_last(self, count: int, case: int) -> None:
        """Marks the last tokens as targets: each is predicted from the token before it."""
        first = len(self.input_ids) - count
        self.target_positions += range(first - 1, len(self.input_ids) - 1)
        self.targets += self.input_ids[first:]
        self.target_cases += [case] * count

    def build(self) -> PackedSequence:
        order, segment, parent = torch.arange(len(self.input_ids)), torch.tensor(self.segment_ids), torch.tensor(self.parent_ids)
        is_visible = (segment[None] == 0) | (segment[:, None] == segment[None]) | (parent[:, None] == segment[None])
        return PackedSequence(
            torch.tensor(self.input_ids),
            torch.tensor(self.position_ids),
            (order[:, None] >= order[None]) & is_visible,
            torch.tensor(self.target_positions),
            torch.tensor(self.targets),
            self.target_cases,
        )


def read_cases(path: str) -> list[Case]:
    with open(path, encoding="utf-8") as lines:
        return [json.loads(line) for line in lines]


def shuffle_lists(text: str, rng: random.Random) -> str:
    """Returns a text whose lists have their lines in another order."""
    shuffled: list[str] = []
    for is_list, group in itertools.groupby(text.split("\n"), lambda line: line.startswith("- ")):
        lines = list(group)
        if is_list:
            rng.shuffle(lines)
        shuffled += lines
    return "\n".join(shuffled)


def draw_examples(examples: Sequence[T], limit: ExampleLimit, rng: random.Random) -> Sequence[T]:
    """Draws worked examples. "any" draws none of them in two fifths of the cases, else any number."""
    if limit is None:
        return examples
    if limit != "any":
        return rng.sample(examples, min(len(examples), rng.randint(0, limit)))
    if rng.random() < 0.4:
        return []
    if rng.random() < 0.5:
        return rng.sample(examples, rng.randint(0, len(examples)))
    return [example for example in examples if rng.random() < 0.7]


def encode_prefix(
    tokenizer: QwenTokenizer, case: Case, rng: random.Random, example_limit: ExampleLimit, shuffles_lists: bool
) -> list[int]:
    """Returns the tokens that the cases of a scene share: the system prompt, worked examples and the scene."""
    [system_role, system_prompt], *turns = case["fixed"]
    examples = draw_examples(list(zip(turns[::2], turns[1::2])), example_limit, rng)
    tokens = tokenizer.encode_message(system_role, shuffle_lists(system_prompt, rng) if shuffles_lists else system_prompt)
    for question, answer in examples:
        tokens += tokenizer.encode_message(*question) + tokenizer.encode_message(*answer)
    scene = shuffle_lists(case["lead"], rng) if shuffles_lists else case["lead"]
    return tokens + tokenizer.encode_message("user", scene, is_open=True)


def encode_instruction(tokenizer: QwenTokenizer, case: Case) -> list[int]:
    """Returns the tokens of an instruction with its rounds, up to the answer."""
    end_of_message = tokenizer.encode_end() + tokenizer.encode("\n")
    tokens = tokenizer.encode(case["instruction"])
    for reply, message in case.get("rounds", []):
        tokens += end_of_message + tokenizer.encode_message("assistant", reply)
        tokens += tokenizer.encode_message("user", message, is_open=True)
    return tokens + end_of_message + tokenizer.encode_message("assistant", "", is_open=True)


def encode_answer(tokenizer: QwenTokenizer, case: Case) -> list[int]:
    """Returns the tokens that are learned: a whole answer, or the beginning of a question."""
    if case["answer"] is None:
        return tokenizer.encode(QUESTION)
    return tokenizer.encode(case["answer"]) + tokenizer.encode_end()


def pack_cases(
    tokenizer: QwenTokenizer, cases: Sequence[Case], rng: random.Random, example_limit: ExampleLimit, shuffles_lists: bool = False
) -> PackedSequence:
    """Packs cases of one scene into a sequence: what they share, then each as a branch, or as a branch of its plan.

    `shuffles_lists` puts the goal words and the entities of the scene in another order.
    """
    builder = SequenceBuilder()
    prefix_end = builder.append(encode_prefix(tokenizer, cases[0], rng, example_limit, shuffles_lists), 0, segment=0)
    # By plan: its segment and the position behind it.
    plans: dict[str, tuple[int, int]] = {}
    for index, case in enumerate(cases):
        parent, first_position = 0, prefix_end
        if "plan" in case:
            if case["plan"] not in plans:
                segment = len(cases) + 1 + len(plans)
                plans[case["plan"]] = segment, builder.append(tokenizer.encode(case["plan"]), prefix_end, segment)
            parent, first_position = plans[case["plan"]]
        answer = encode_answer(tokenizer, case)
        builder.append(encode_instruction(tokenizer, case) + answer, first_position, segment=index + 1, parent=parent)
        builder.learn_last(len(answer), index)
    return builder.build()


def concatenate(sequences: Sequence[PackedSequence]) -> PackedSequence:
    """Returns several sequences as one; none sees another. It has no `target_cases`."""
    offsets = itertools.accumulate((len(sequence.input_ids) for sequence in sequences), initial=0)
    return PackedSequence(
        torch.cat([sequence.input_ids for sequence in sequences]),
        torch.cat([sequence.position_ids for sequence in sequences]),
        torch.block_diag(*(sequence.attention_mask for sequence in sequences)).bool(),  # type: ignore[no-untyped-call]
        torch.cat([sequence.target_positions + offset for sequence, offset in zip(sequences, offsets)]),
        torch.cat([sequence.targets for sequence in sequences]),
        [],
    )


def group_cases(cases: Sequence[Case], pack_size: int, rng: random.Random) -> list[list[Case]]:
    """Returns the cases in groups of one scene with about `pack_size` cases, in random order."""
    scenes: dict[tuple[str, str], list[Case]] = {}
    for case in cases:
        scenes.setdefault((case["suite"], case["lead"]), []).append(case)
    groups: list[list[Case]] = []
    for scene_cases in scenes.values():
        rng.shuffle(scene_cases)
        count = max(1, round(len(scene_cases) / pack_size))
        if "plan" in scene_cases[0]:
            # Cases about one plan stay together.
            scene_cases.sort(key=lambda case: case["plan"])
            bounds = [len(scene_cases) * index // count for index in range(count + 1)]
            groups += [scene_cases[first:end] for first, end in itertools.pairwise(bounds)]
        else:
            groups += [scene_cases[first::count] for first in range(count)]
    rng.shuffle(groups)
    return groups
