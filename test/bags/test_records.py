"""Messages found in cycles are those found one by one, whatever the order of topics in the file."""

from pathlib import Path

import numpy as np
import pytest
from bag_writer import ROS1_STORE, STORE, Message, mcap_file, ns, ros1_bag

from flex_ident.bags.messages import Block
from flex_ident.bags.storage import Bag

KIND = "std_msgs/msg/Float64MultiArray"
ORDERS = {
    "one topic": lambda i, _: "a",
    "two in turns": lambda i, _: "ab"[i % 2],
    "three rates": lambda i, _: "abacaba"[i % 7],
    "one twice in a row": lambda i, _: "aab"[i % 3],
    "long cycle": lambda i, _: "abcabcaabbccab"[i % 14],
    "any order": lambda i, random: "abc"[int(random.integers(3))],
    "turns with swaps": lambda i, random: "abc"[(i + int(random.random() < 0.02)) % 3],
    "rarely another": lambda i, _: "b" if i % 97 == 13 else "a",
}


def messages(order: str, sizes: str, store: object) -> list[Message]:
    """2000 messages that count up, of topics in the given order; arrays of one length, or of several."""
    random = np.random.default_rng(len(order))
    layout = store.types["std_msgs/msg/MultiArrayLayout"]([], 0)
    made = []
    for i in range(2000):
        topic = ORDERS[order](i, random)
        length = {"equal": 3, "by topic": 2 + ord(topic) % 3, "changing": 1 + i // 300 % 3}[sizes]
        content = store.types[KIND](layout, np.full(length, float(i)))
        made.append(Message(f"/{topic}", ns(0.001 * i), KIND, content))
    return made


def numbers(block: Block) -> list[float]:
    return [float(np.frombuffer(block.payload(i)[-8:], "<f8")[0]) for i in range(block.lengths.size)]


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("sizes", ["equal", "by topic", "changing"])
@pytest.mark.parametrize("kind", ["mcap", "mcap without chunks", "ROS 1"])
def test_each_topic_is_whole_and_in_order(tmp_path: Path, order: str, sizes: str, kind: str) -> None:
    made = messages(order, sizes, ROS1_STORE if kind == "ROS 1" else STORE)
    if kind == "ROS 1":
        path = ros1_bag(tmp_path / "bag.bag", made)
    else:
        path = mcap_file(tmp_path / "bag.mcap", made, chunked=kind == "mcap")
    found: dict[str, list[float]] = {}
    times: dict[str, list[int]] = {}
    with Bag(path) as bag:
        for block in bag.blocks(frozenset({"/a", "/b"})):
            found.setdefault(block.topic, []).extend(numbers(block))
            times.setdefault(block.topic, []).extend(block.received.tolist())
    for topic in {m.topic for m in made} - {"/c"}:
        own = [(float(i), m.received_ns) for i, m in enumerate(made) if m.topic == topic]
        assert found[topic] == [number for number, _ in own]
        assert times[topic] == [received for _, received in own]
    assert "/c" not in found
