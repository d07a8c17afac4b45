"""Services that answer whatever happens."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.node import Node

from node_runner.executor import describe


def answer_always(node: Node, report: Callable[[Exception], None]) -> None:
    """Let a node's services answer a request whose callback raises, which rclpy leaves unanswered.

    Parameters
    ----------
    node : Node
        With all its services.
    report : callable
        Called with what was raised.
    """
    for service in node.services:
        service.callback = _answering(service.srv_type, service.callback, report)


def _answering(service_type: Any, callback: Callable, report: Callable) -> Callable:
    def answer(request, response):
        try:
            return callback(request, response)
        except Exception as error:
            report(error)
            return _refusal(service_type, request, describe(error))

    return answer


def _refusal(service_type: Any, request: Any, reason: str) -> Any:
    """Return a response that says no, as far as its type can."""
    response = service_type.Response()
    result = SetParametersResult(successful=False, reason=reason)
    if service_type is SetParameters:
        response.results = [result] * len(request.parameters)
    elif service_type is SetParametersAtomically:
        response.result = result
    elif hasattr(response, 'message'):
        response.message = reason
    return response
