"""Walking through the links of a node tree, groups and reroutes included."""


class Input:
    """An input of a node, followed to where its value comes from.

    `node`, `output` and `groups` say which output of which node feeds it, within the groups that were entered on the way;
    `node` is None where nothing does, and `default` is then the value that holds.
    """

    def __init__(self, socket, groups=()):
        self.name = socket.name
        self.node = self.output = None
        self.groups = groups
        while True:
            links = [link for link in socket.links if not link.is_muted] if socket.is_linked else []
            if not links:
                self.default = getattr(socket, "default_value", None)
                return
            output = links[0].from_socket
            node = output.node
            if node.mute:
                inner = [link.from_socket for link in node.internal_links if link.to_socket == output]
                if not inner:
                    self.default = getattr(socket, "default_value", None)
                    return
                socket = inner[0]
            elif node.bl_idname == "NodeReroute":
                socket = node.inputs[0]
            elif node.bl_idname == "ShaderNodeGroup" and node.node_tree:
                ends = [n for n in node.node_tree.nodes if n.bl_idname == "NodeGroupOutput" and n.is_active_output]
                if not ends:
                    self.default = getattr(socket, "default_value", None)
                    return
                self.groups = self.groups + (node,)
                socket = _twin(ends[0].inputs, output)
            elif node.bl_idname == "NodeGroupInput" and self.groups:
                socket = _twin(self.groups[-1].inputs, output)
                self.groups = self.groups[:-1]
            else:
                self.node, self.output = node, output
                self.default = None
                return


def _twin(sockets, socket):
    return next(s for s in sockets if s.identifier == socket.identifier)


def input_of(node, groups, *names):
    """A node's input by the first of the names that it has (they differ between Blender's versions); None without one."""
    for name in names:
        for socket in node.inputs:
            if socket.enabled and name in (socket.name, socket.identifier):
                return Input(socket, groups)
    return None


def output_node(tree, kind):
    """The active output node of a tree for Cycles or all renderers."""
    found = [n for n in tree.nodes if n.bl_idname == kind and n.is_active_output]
    found = [n for n in found if getattr(n, "target", "ALL") in ("ALL", "CYCLES")] or found
    return found[0] if found else None
