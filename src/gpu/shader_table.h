/* The shader files, embedded by shaders/embed.py. The last entry's path is NULL. */
#ifndef FURROW_GPU_SHADER_TABLE_H
#define FURROW_GPU_SHADER_TABLE_H

struct shader_text {
	const char *path; /* below shaders/: "lib/lattice.glsl" */
	const char *text;
};

extern const struct shader_text gpu_shader_table[];

#endif
