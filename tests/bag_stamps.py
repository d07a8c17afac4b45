"""The stamps of what a bag holds."""


def stamps_of(reader, topic):
    """Yield the topic's ticks, by its messages' stamps."""
    connections = [c for c in reader.connections if c.topic == topic]
    for connection, _, data in reader.messages(connections=connections):
        stamp = reader.deserialize(data, connection.msgtype).header.stamp
        yield round(stamp.sec * 10 + stamp.nanosec * 1e-8) - 1
