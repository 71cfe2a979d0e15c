#version 450 core
// What soil that a body carries is at a pixel, as numbers: see measure.frag.
in vec3 place;
in vec3 normal;
flat in vec2 along;
flat in int heap_class;
layout(location = 0) out vec4 measured;

void main()
{
	measured = vec4(normalize(normal).xy, place.z, 1.0 + float(heap_class));
}
