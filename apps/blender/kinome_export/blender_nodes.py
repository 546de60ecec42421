"""Reads Blender's shader nodes into the dictionaries that textures.py describes."""
import bpy


def surface_of(tree, target="Surface"):
    """Returns the node that is connected to an input of the active output; None if there is none. A node
    with several links is the same dictionary in all of them."""
    socket = _target(tree, target)
    link = _Reader().input(socket, ()) if socket is not None else None
    return link["node"] if isinstance(link, dict) else None


def has(tree, target):
    """Returns True if a node is connected to an input of the active output."""
    socket = _target(tree, target)
    return socket is not None and isinstance(_source(socket, ()), tuple)


def _target(tree, target):
    """Returns an input of the active output, or None."""
    outputs = [n for n in tree.nodes if n.bl_idname in ("ShaderNodeOutputMaterial", "ShaderNodeOutputWorld",
                                                       "ShaderNodeOutputLight")
               and n.is_active_output and getattr(n, "target", "ALL") in ("ALL", "CYCLES")]
    return outputs[0].inputs[target] if outputs and target in outputs[0].inputs else None


class _Reader:
    """Reads nodes, each of them once. In a chain of nodes with two links to the one before, there are
    exponentially many ways to the first node."""

    def __init__(self):
        self._nodes = {}  # by the node and the groups around it

    def input(self, socket, groups):
        """Returns the value of an input or a link. `groups` are the nodes of the groups around it."""
        default = _default(socket)
        source = _source(socket, groups)
        if source is None:
            return default
        if not isinstance(source, tuple):
            return _default(source)
        output, inner = source
        key = tuple(node.as_pointer() for node in (output.node, *inner))
        if key not in self._nodes:
            self._nodes[key] = _node(output.node, lambda one: self.input(one, inner))
        return {"node": self._nodes[key], "output": output.name, "default": default}


def _source(socket, groups):
    """Follows links through groups, reroutes and muted nodes. Returns the output and the groups around
    it, or an unconnected input of a group, or None."""
    while socket.is_linked:
        output = socket.links[0].from_socket
        node = output.node
        if node.type == "REROUTE":
            socket = node.inputs[0]
        elif node.mute:
            inner = [link for link in node.internal_links if link.to_socket == output]
            if not inner:
                return None
            socket = inner[0].from_socket
        elif node.type == "GROUP" and node.node_tree:
            ends = [n for n in node.node_tree.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output]
            if not ends:
                return None
            groups = (*groups, node)
            socket = next(s for s in ends[0].inputs if s.identifier == output.identifier)
        elif node.type == "GROUP_INPUT" and groups:
            socket = next(s for s in groups[-1].inputs if s.identifier == output.identifier)
            groups = groups[:-1]
            if not socket.is_linked:
                return socket
        else:
            return output, groups
    return None


def _default(socket):
    value = getattr(socket, "default_value", None)
    if value is None or isinstance(value, (str, bool)):
        return 0.0
    return float(value) if isinstance(value, (int, float)) else [float(v) for v in value]


def _node(node, read):
    """Returns the dictionary of a node. read(socket) returns the value of an input or a link."""
    kind = "BSDF_GLOSSY" if node.type == "BSDF_ANISOTROPIC" else node.type
    result = {"type": kind, "name": node.label or node.name,
              "inputs": {s.name: read(s) for s in node.inputs if s.type != "SHADER" and _is_used(node, s)}}
    if kind in ("MIX_SHADER", "ADD_SHADER"):
        result["shaders"] = [read(s) for s in node.inputs if s.type == "SHADER"]
    for name in ("vector_type", "space", "invert", "projection", "extension", "interpolation",
                 "data_type", "blend_type", "clamp_result", "use_clamp", "operation", "mode"):
        if hasattr(node, name):
            result[name] = getattr(node, name)
    if kind == "MATH":
        result["values"] = [read(s) for s in node.inputs if s.enabled]
    if kind == "VALTORGB":
        result["ramp"] = [list(node.color_ramp.evaluate(i / 256)) for i in range(257)]
    if kind in ("RGB", "VALUE"):
        result["value"] = _default(node.outputs[0])
    elif kind in ("TEX_IMAGE", "TEX_ENVIRONMENT"):
        result["image"] = node.image
        result["is_data"] = bool(node.image and node.image.colorspace_settings.is_data)
    elif kind in ("VERTEX_COLOR", "ATTRIBUTE"):
        name = node.layer_name if kind == "VERTEX_COLOR" else node.attribute_name
        result["attribute"] = name
        result["is_color"] = (kind == "VERTEX_COLOR" and not name) or \
            any(name in mesh.color_attributes for mesh in bpy.data.meshes)
    return result


def _is_used(node, socket):
    """Returns false for inputs of a Mix node for other types of data, which have the same names."""
    return node.type != "MIX" or socket.enabled
