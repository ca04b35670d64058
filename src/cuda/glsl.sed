# SPDX-License-Identifier: Apache-2.0
# Translates GLSL to C++ (sed -E) where the two differ in spelling only; glsl.hpp defines the types and functions. A
# translated stage becomes the body of a struct: its arrays are members that bindings.glsl initialises, its functions
# are member functions.

# Lines that only Vulkan needs.
/^#version|^#extension|^layout\(local_size|^#define GNO_(CONST|INLINE)\b/d
# RAYS is a template argument, because arrays have this size, and with it SPREAD_RAYS.
/^layout\(constant_id = [0-9]+\) const uint (RAYS|SPREAD_RAYS) /d
# The lanes decide these two.
/^layout\(constant_id = [0-9]+\) const (uint kVertexRounds|bool kLanesInStep) /d
s/__cplusplus/GNO_NEVER/
s/GNOSPHERE_(\w+)_H\b/GNOSPHERE_CUDA_\1_H/
s/\bprecise //g
s/\[\[dont_unroll\]\]/GNO_DONT_UNROLL/
s/\[\[unroll\]\]/GNO_UNROLL/

# Arrays, constants and workgroup memory.
s/\.at\[/[/g
/^layout\(buffer_reference.*Words64/d
s/^Words64 words64 = Words64\(words\);/uint64_t* words64 = reinterpret_cast<uint64_t*>(words);/
s/^layout\(constant_id = [0-9]+\) const (\w+) (\w+) = [^;]*;/GNO_OPTION(\1, \2);/
s/^shared (\w+) (\w+)\[([^]]+)\];/GNO_SHARED_ARRAY(\1, \2, \3);/
s/^(const|GNO_CONST) /static constexpr /
/^(float|uint|vec2) \w+\[\w+\](, \w+\[\w+\])*;/{
  s/^(\w+) (\w+)\[(\w+)\]/GNO_PRIVATE_ARRAY(\1, \2, \3)/
  :next
  s/^(GNO_PRIVATE_ARRAY\((\w+), .*\)), (\w+)\[(\w+)\]/\1; GNO_PRIVATE_ARRAY(\2, \3, \4)/
  tnext
}

# Functions; a class needs no forward declarations.
/^\w+ \w+\([^)]*\);$/d
s/^(GNO_INLINE )?(\w+) (\w+)\(/GNO_DEVICE \2 \3(/
s/^#define GNO_(IN)?OUT\(type\) .*/#define GNO_\1OUT(type) type\&/
s/([(,] ?|^ +)(in)?out (\w+) (\w+)/\1\3\& \4/g

# Components and literals: 1.0 is a float, 1.0lf a double.
s/\.([xyzw]{2,4})\b/.\1()/g
s/([0-9.])lf\b/\1@/g
s/(^|[^A-Za-z0-9_.])([0-9]+\.[0-9]*(e[-+]?[0-9]+)?|[0-9]+e[-+]?[0-9]+)([^0-9A-Za-z_.@]|$)/\1\2f\4/g
s/(^|[^A-Za-z0-9_.])([0-9]+\.[0-9]*(e[-+]?[0-9]+)?|[0-9]+e[-+]?[0-9]+)([^0-9A-Za-z_.@]|$)/\1\2f\4/g
s/([0-9.])@/\1/g

# Structs that are loaded as a whole, 16 bytes at a time.
s/^struct (Instance|Cluster|Group|TaggedCorner|SurfaceRecord|ClusterBones) \{/struct alignas(16) \1 {/
