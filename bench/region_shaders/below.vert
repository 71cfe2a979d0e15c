#version 450 core
// A sphere as triangles, drawn from below onto posts, as the dissertation draws its object (4.4.1, 5.5): the depth buffer keeps its lowest
// height. A vertex has no attributes: rings and sectors are counted.

layout(std140, binding = 0) uniform params {
	vec4 centre; // posts from the target's first post, x and y; metres: height; the radius in metres
	vec4 scale;  // posts of the target in x and y; heights that the depth buffer holds: lowest, range, metres
	ivec4 parts; // rings from the lowest point to the equator, sectors
	vec4 spacing; // metres
};

void main()
{
	const ivec2 corners[6] = ivec2[6](ivec2(0, 0), ivec2(1, 0), ivec2(1, 1), ivec2(0, 0), ivec2(1, 1), ivec2(0, 1));
	int square = gl_VertexID / 6;
	ivec2 at = ivec2(square / parts.y, square % parts.y) + corners[gl_VertexID % 6];
	float tilt = 1.5707963267948966 * float(at.x) / float(parts.x), turn = 6.283185307179586 * float(at.y) / float(parts.y);
	vec2 plan = centre.xy + sin(tilt) * centre.w / spacing.x * vec2(cos(turn), sin(turn));
	float height = centre.z - cos(tilt) * centre.w;
	// A post lies in the middle of its pixel.
	gl_Position = vec4((plan + 0.5) / scale.xy * 2.0 - 1.0, 1.0 - (height - scale.z) / scale.w, 1.0);
}
