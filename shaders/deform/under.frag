#version 450 core
// The lower envelope of a swept object above each post of the window: fixed-point units from the window's zero height.
// Defines: SHAPE_WHEEL, SHAPE_SPHERE or SHAPE_BOX; REST: also of its end pose; SIDEWAYS: the wheel moves sideways; PASSED: the
// parameters come from passed.vert.

#include "lib/envelope.glsl"
#include "lib/window.glsl"

layout(location = 0) out int under_out;
#ifdef REST
layout(location = 1) out int rest_out;
#endif

void main()
{
	ivec2 post = ivec2(gl_FragCoord.xy);
	int height;
	under_out = envelope(0, post, height) ? height : UNDER_NONE;
#ifdef REST
#ifdef AT_REST
	rest_out = envelope_at_rest(1, post, height) ? height : UNDER_NONE;
#else
	rest_out = envelope(1, post, height) ? height : UNDER_NONE;
#endif
#endif
}
