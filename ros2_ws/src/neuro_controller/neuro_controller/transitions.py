"""What rclpy leaves undone when a lifecycle transition cannot be made or fails."""

from rclpy.impl.implementation_singleton import rclpy_implementation

from node_runner import describe


def make_transitions_safe(node, complaints):
    """Let a node answer a transition that its state forbids, and tell of one that fails.

    rclpy would let the process die of the one, and say nothing of the other.

    Parameters
    ----------
    node : rclpy.lifecycle.LifecycleNode
        Its ``on_failure`` is called with what a transition's callback raised.
    complaints : node_runner.Complaints
    """
    change_state = node._service_change_state.callback

    def refuse(request, response):
        try:
            return change_state(request, response)
        except rclpy_implementation.RCLError:
            complaints.warn(
                f'transition refused: {request.transition.label or request.transition.id} '
                'is not possible in this state'
            )
            response.success = False
            return response

    def telling(callback):
        def tell(state):
            try:
                return callback(state)
            except Exception as error:
                complaints.error(f'a transition failed with {describe(error)}')
                node.on_failure(describe(error))
                raise

        return tell

    node._service_change_state.callback = refuse
    for state, callback in node._callbacks.items():
        node._callbacks[state] = telling(callback)
