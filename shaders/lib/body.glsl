// The look of the ground, the sky and the sun on each planet. These are constants and not parameters, since there are many, and a
// software rasteriser reads each parameter anew at every pixel. Colours are linear. A white surface that faces the Earth's sun has
// 2.6. Each kind of ground has two colours: the first where its texture has the hue 0, the second where it has the hue 1.
#if defined MARS
const vec3 sand_colours[2] = vec3[](vec3(0.165, 0.092, 0.056), vec3(0.230, 0.128, 0.074));
const vec3 cover_colours[2] = vec3[](vec3(0.260, 0.128, 0.058), vec3(0.340, 0.180, 0.085)); // dust
const vec3 soil_colours[2] = vec3[](vec3(0.210, 0.103, 0.050), vec3(0.190, 0.118, 0.078));
const vec3 rock_colours[2] = vec3[](vec3(0.140, 0.078, 0.048), vec3(0.250, 0.146, 0.088));
const vec3 snow_colours[2] = vec3[](vec3(0.700, 0.640, 0.600), vec3(0.700, 0.640, 0.600)); // only where a soil map has snow
const float snow_lies = 0.0, water = 0.0, stars = 0.0;
const vec3 low_colour = vec3(0.200, 0.100, 0.050), high_colour = vec3(0.300, 0.160, 0.080); // of low and high ground, without textures
const vec3 skylight = vec3(0.46, 0.34, 0.22), groundlight = vec3(0.24, 0.14, 0.08);
const vec3 zenith = vec3(0.300, 0.190, 0.112), middle = vec3(0.460, 0.300, 0.170), horizon = vec3(0.660, 0.445, 0.265);
const vec3 toward = vec3(0.700, 0.600, 0.500), halo = vec3(0.18, 0.24, 0.33); // dust scatters blue forward
const float sky_falls = 1.8, haze_falls = 5.0, haze_turns = 0.7, sun_edge = 0.99995;
#elif defined MOON
const vec3 sand_colours[2] = vec3[](vec3(0.072, 0.070, 0.068), vec3(0.092, 0.090, 0.087)); // maria
const vec3 cover_colours[2] = vec3[](vec3(0.108, 0.104, 0.098), vec3(0.132, 0.128, 0.122)); // regolith
const vec3 soil_colours[2] = vec3[](vec3(0.098, 0.095, 0.090), vec3(0.160, 0.155, 0.148));
const vec3 rock_colours[2] = vec3[](vec3(0.120, 0.116, 0.110), vec3(0.190, 0.186, 0.178));
const vec3 snow_colours[2] = vec3[](vec3(0.160, 0.156, 0.150), vec3(0.160, 0.156, 0.150));
const float snow_lies = 0.0, water = 0.0, stars = 0.25;
const vec3 low_colour = vec3(0.095, 0.092, 0.088), high_colour = vec3(0.150, 0.146, 0.140);
const vec3 skylight = vec3(0.012), groundlight = vec3(0.110, 0.106, 0.100); // reflected by the lit ground around
const vec3 zenith = vec3(0.0), middle = vec3(0.0), horizon = vec3(0.0), toward = vec3(0.0), halo = vec3(0.0);
const float sky_falls = 1.0, haze_falls = 1.0, haze_turns = 0.0, sun_edge = 0.99995;
#else
const vec3 sand_colours[2] = vec3[](vec3(0.330, 0.260, 0.170), vec3(0.440, 0.360, 0.250));
const vec3 cover_colours[2] = vec3[](vec3(0.045, 0.064, 0.018), vec3(0.170, 0.150, 0.058)); // grass, straw
const vec3 soil_colours[2] = vec3[](vec3(0.115, 0.080, 0.050), vec3(0.300, 0.260, 0.200));
const vec3 rock_colours[2] = vec3[](vec3(0.085, 0.079, 0.074), vec3(0.200, 0.180, 0.153));
const vec3 snow_colours[2] = vec3[](vec3(0.720, 0.760, 0.820), vec3(0.720, 0.760, 0.820));
const float snow_lies = 1.0, water = 1.0, stars = 0.0;
const vec3 low_colour = vec3(0.130, 0.105, 0.075), high_colour = vec3(0.270, 0.240, 0.200);
const vec3 skylight = vec3(0.40, 0.50, 0.64), groundlight = vec3(0.22, 0.19, 0.15);
const vec3 zenith = vec3(0.075, 0.19, 0.50), middle = vec3(0.22, 0.42, 0.74), horizon = vec3(0.50, 0.62, 0.76);
const vec3 toward = vec3(0.95, 0.83, 0.66), halo = vec3(0.25, 0.215, 0.165);
const float sky_falls = 2.2, haze_falls = 7.0, haze_turns = 0.55, sun_edge = 0.99989;
#endif
