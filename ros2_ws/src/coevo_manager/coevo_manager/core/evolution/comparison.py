"""What the methods of one comparison have in common (Nolfi and Pagliuca 2025)."""

from __future__ import annotations

from typing import Any

OPENAI_ES: dict[str, Any] = {
    'optimizer': 'openai_es',
    'openai_pairs': 20,
    'openai_sigma': 0.1,
    'openai_step': 0.05,
    'openai_decay': 0.01,
    'optimizer_memory': 'kept',
}
"""OpenAI-ES as that comparison runs it. Its genes are of order 1, ours span +-5, so that its sigma
0.02 and step 0.01 are five times as long here. Of its gradient, which is not divided by sigma,
0.005 a gene is taken; of ours, which is, 0.005 / 5 / 0.1."""
