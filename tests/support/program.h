/* A folder's tests are one program: `test_FOLDER NAME [FILTER]` runs the file NAME.c, or those of its tests that FILTER names. */
#ifndef FURROW_TESTS_SUPPORT_PROGRAM_H
#define FURROW_TESTS_SUPPORT_PROGRAM_H

/* Begins the function that runs one file's tests, as `int main(void)` would. It returns how many failed. */
#define TEST_PROGRAM(name)                                                                         \
	int test_##name(void);                                                                     \
	int test_##name(void)

/* The words behind NAME, with a NULL at the end: for a test that starts its own program again. More than one are no filter. */
extern char **program_words;

#endif
