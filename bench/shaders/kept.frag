#version 450 core
// One plane of a tile between the lattice and the format that a bench keeps it in.
// ENCODE: from the lattice; otherwise back to it. BASE: quanta of 2^-18 m and BASE_NODATA; otherwise an offset's, of
// 2^-20 m. NORMALISED: codes from 1 to `top` as shares of it, nodata 0; otherwise metres as floats; HALF: of 16 bits.

const int BASE_NODATA = int(0x80000000u);
const float NODATA = -65504.0; // the lowest that a half float holds

#ifdef BASE
const float QUANTA = 262144.0; // a metre
#else
const float QUANTA = 1048576.0;
#endif

layout(std140, binding = 0) uniform params {
	float low;   // metres that `zero` is
	float zero;  // a code
	float codes; // a metre
	float top;
};

#ifdef ENCODE
layout(binding = 0) uniform isampler2D plane;
layout(location = 0) out float kept;

// To the nearest half float: what a driver makes of others is its own choice (llvmpipe cuts them off).
float rounded(float metres)
{
#ifdef HALF
	int exponent;
	frexp(metres, exponent);
	float last = ldexp(1.0, max(exponent - 11, -24));
	return roundEven(metres / last) * last;
#else
	return metres;
#endif
}

void main()
{
	int quanta = texelFetch(plane, ivec2(gl_FragCoord.xy), 0).r;
	float metres = float(quanta) / QUANTA;
	bool nodata = quanta == BASE_NODATA;
#ifdef NORMALISED
	kept = nodata ? 0.0 : clamp(floor(zero + (metres - low) * codes + 0.5), 1.0, top) / top;
#else
	kept = nodata ? NODATA : rounded(metres);
#endif
}
#else
layout(binding = 0) uniform sampler2D plane;
layout(location = 0) out int quanta;

void main()
{
	float kept = texelFetch(plane, ivec2(gl_FragCoord.xy), 0).r;
#ifdef NORMALISED
	float code = floor(kept * top + 0.5), metres = low + (code - zero) / codes;
	bool nodata = code == 0.0;
#else
	float metres = kept;
	bool nodata = kept == NODATA;
#endif
	quanta = nodata ? BASE_NODATA : int(floor(metres * QUANTA + 0.5));
}
#endif
