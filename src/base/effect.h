/* One row of the table of effects: the key that turns an effect on, the data that it reads and writes, and its limits. */
#ifndef FURROW_BASE_EFFECT_H
#define FURROW_BASE_EFFECT_H

struct effect_row {
	const char *name;    /* its name in a scene, if it has one */
	const char *key;     /* the scene's key that turns it on: "redistribute.model" */
	const char *define;  /* define of the shader variant, "" if it has its own program */
	const char *const *shaders; /* files, NULL-terminated; the first has the define */
	const char *reads, *writes; /* planes, or other data in words */
	int stencil;         /* the farthest post that it reads around the post it writes, in posts */
	const char *const *parameters; /* keys of the scene, NULL-terminated */
	const char *limits;  /* in words, with numbers */
	const char *what;    /* description in one line */
};

/* A NULL-terminated list of texts for these rows. */
#define EFFECT_LIST(...) (const char *const[]){__VA_ARGS__, NULL}
#define EFFECT_LIST_NONE (const char *const[]){NULL}

#endif
