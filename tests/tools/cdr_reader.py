"""Decodes CDR samples with the OMG IDL that stands in a recording, written from both specifications and sharing no code with
palp."""

import re
import struct


class Wrong(Exception):
    pass


def check(condition, text):
    if not condition:
        raise Wrong(text)


PRIMITIVES = {"boolean": "?", "octet": "B", "char": "c", "short": "h", "unsigned short": "H", "long": "i",
              "unsigned long": "I", "long long": "q", "unsigned long long": "Q", "float": "f", "double": "d",
              "int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I", "int64": "q", "uint64": "Q"}


class Idl:
    """The part of OMG IDL that palp uses: modules, structs, typedefs, constants, arrays, sequences, strings."""

    def __init__(self, text):
        text = re.sub(r"//[^\n]*|/\*.*?\*/", " ", text, flags=re.S)
        self.tokens = re.findall(r"[A-Za-z_]\w*(?:::[A-Za-z_]\w*)*|\d+|@\w+|[{}()\[\]<>;,=]", text)
        self.types, self.constants, self.scope = {}, {}, []
        while self.tokens:
            self.definition()

    def next(self, expected=None):
        check(self.tokens, "the IDL ends too early")
        token = self.tokens.pop(0)
        check(expected is None or token == expected, f"the IDL has '{token}' where '{expected}' belongs")
        return token

    def accept(self, token):
        if self.tokens and self.tokens[0] == token:
            return self.tokens.pop(0)
        return None

    def annotations(self):
        while self.tokens and self.tokens[0].startswith("@"):
            self.next()
            if self.accept("("):
                while self.next() != ")":
                    pass

    def define(self, name, value):
        self.types["::".join(self.scope + [name])] = value

    def find(self, name):
        for depth in range(len(self.scope), -1, -1):
            found = "::".join(self.scope[:depth] + [name])
            if found in self.types:
                return ("named", found)
        raise Wrong(f"the IDL names the unknown type {name}")

    def definition(self):
        self.annotations()
        kind = self.next()
        if kind == "module":
            self.scope.append(self.next())
            self.next("{")
            while not self.accept("}"):
                self.definition()
            self.scope.pop()
        elif kind == "struct":
            name, members = self.next(), []
            self.next("{")
            while not self.accept("}"):
                self.annotations()
                members.append(self.declaration())
                self.next(";")
            self.define(name, ("struct", members))
        elif kind == "typedef":
            name, target = self.declaration()
            self.define(name, target)
        elif kind == "const":
            self.type()
            name = self.next()
            self.next("=")
            self.constants[name] = int(self.next())
        else:
            raise Wrong(f"the IDL has '{kind}', which this reader does not know")
        self.next(";")

    def declaration(self):
        target, name = self.type(), self.next()
        sizes = []
        while self.accept("["):
            sizes.append(self.size())
            self.next("]")
        for size in reversed(sizes):
            target = ("array", target, size)
        return name, target

    def size(self):
        token = self.next()
        return int(token) if token.isdigit() else self.constants[token]

    def type(self):
        token = self.next()
        if token == "sequence":
            self.next("<")
            element = self.type()
            if self.accept(","):
                self.size()
            self.next(">")
            return ("sequence", element)
        if token == "string":
            if self.accept("<"):
                self.size()
                self.next(">")
            return ("string",)
        words = [token]
        while self.tokens and " ".join(words + self.tokens[:1]) in (*PRIMITIVES, "unsigned long"):
            words.append(self.next())
        name = " ".join(words)
        return ("primitive", PRIMITIVES[name]) if name in PRIMITIVES else self.find(name)


class Cdr:
    """Decodes plain XCDR1."""

    def __init__(self, payload, idl):
        check(payload[:2] in (b"\x00\x00", b"\x00\x01"), "the payload is not plain CDR")
        self.order = "<" if payload[1] == 1 else ">"
        self.data, self.at, self.idl = payload[4:], 0, idl

    def numbers(self, code, count):
        size = struct.calcsize(code)
        if count == 0:
            return ()
        self.at = (self.at + size - 1) // size * size
        check(self.at + size * count <= len(self.data), "a payload is too short")
        self.at += size * count
        return struct.unpack_from(f"{self.order}{count}{code}", self.data, self.at - size * count)

    def value(self, kind):
        if kind[0] == "named":
            return self.value(self.idl.types[kind[1]])
        if kind[0] == "primitive":
            return self.numbers(kind[1], 1)[0]
        if kind[0] == "string":
            size = self.numbers("I", 1)[0]
            check(0 < size <= len(self.data) - self.at, "a string is too long")
            self.at += size
            check(self.data[self.at - 1] == 0, "a string has no end")
            return self.data[self.at - size : self.at - 1].decode()
        if kind[0] == "struct":
            return {name: self.value(member) for name, member in kind[1]}
        count = kind[2] if kind[0] == "array" else self.numbers("I", 1)[0]
        check(count <= len(self.data), "a sequence is too long")
        if kind[1][0] == "primitive":
            return list(self.numbers(kind[1][1], count))
        return [self.value(kind[1]) for _ in range(count)]


def decode(payload, idl, type_name):
    cdr = Cdr(payload, idl)
    value = cdr.value(("named", type_name))
    check(len(cdr.data) - cdr.at < 4, "a payload is longer than its type")
    return value
