// Linked as no program of ours may be; it is never run.
int main() {}
